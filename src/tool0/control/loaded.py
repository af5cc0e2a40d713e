"""A loaded controller in any stage of its life."""

from __future__ import annotations

from typing import final

from tool0.control.config import ControllerConfig
from tool0.control.controller import Controller, ControllerSpec
from tool0.errors import ControlError
from tool0.hardware.engine import JointState


@final
class LoadedController:
    """A controller's parameters once it is configured, and itself while it runs."""

    def __init__(self, name: str, config: ControllerConfig) -> None:
        self.name = name
        self.config = config
        self.type = config.type_of(name)
        self.spec: ControllerSpec | None = None
        self.indices: tuple[int, ...] = ()
        self.controller: Controller | None = None
        self.state = config.dialect.stages.unconfigured
        self.is_waiting = False
        """Whether the brakes hold its joints until its first command."""

    @property
    def claims(self) -> tuple[str, ...]:
        """The joints that it claims."""
        spec = self.spec
        return () if spec is None or spec.interface is None else spec.joints

    @property
    def command_interfaces(self) -> tuple[str, ...]:
        """What it claims, as ROS 2 names it."""
        spec = self.spec
        if spec is None:
            return ()
        if spec.interface is None:
            return spec.further_interfaces
        kind = spec.interface.name.lower()
        names = (f"{joint}/{kind}" for joint in spec.joints)
        return (*names, *spec.further_interfaces)

    def started(self, state: JointState) -> Controller:
        """Return a new running controller."""
        return self.configured.start(self.indices, state)

    @property
    def configured(self) -> ControllerSpec:
        """Its parameters, or raise ControlError."""
        if self.spec is None:
            raise ControlError(
                f"controller '{self.name}' is {self.state}; configure it with "
                f"`tool0 controllers configure {self.name}` or "
                f"robot.configure('{self.name}')"
            )
        return self.spec
