"""A loaded controller in any stage of its life cycle."""

from __future__ import annotations

from typing import final

from tool0.control.arm.mode import ArmModeSpec
from tool0.control.config import ControllerConfig
from tool0.control.controller import Controller, ControllerSpec
from tool0.control.dialect import Stages
from tool0.description.model import Interface
from tool0.errors import ControlError
from tool0.hardware.engine import JointState
from tool0.hardware.robot_hardware import EffortLaw


@final
class LoadedController:
    """A loaded controller, and its parameters once it has been configured."""

    def __init__(
        self, name: str, type_name: str, stages: Stages, config: ControllerConfig | None
    ) -> None:
        self.name = name
        self.type = type_name
        self.config = config
        """Parameters in YAML; None for the internal controllers of tool0, which
        requests start and stop."""
        self.spec: ControllerSpec | None = None
        self.indices: tuple[int, ...] = ()
        self.controller: Controller | None = None
        self.state = stages.unconfigured
        self.is_waiting = False
        """Whether the brakes hold the controller's joints until its first command."""
        self.effort_law: EffortLaw | None = None
        """Effort law that drives the joints instead of the controller's commands; None
        if there is no such law."""
        self.has_rotors = False
        """Whether the effort law includes the rotor inertias of the joints."""

    @property
    def interface(self) -> Interface | None:
        """The interface through which the controller commands its joints."""
        if self.effort_law is not None and self.is_own:
            return Interface.EFFORT
        return None if self.spec is None else self.spec.interface

    @property
    def is_own(self) -> bool:
        """Whether the controller is internal to tool0 and has no YAML."""
        return self.config is None

    def require_config(self) -> ControllerConfig:
        """Return the YAML; raise ControlError for an internal controller of tool0."""
        if self.config is None:
            raise ControlError(self.why_fixed)
        return self.config

    @property
    def why_fixed(self) -> str:
        """Reason why clients cannot start, stop or change an internal controller."""
        return (
            f"controller '{self.name}' is tool0's own: `take_arm` starts it, and "
            "`return_arm` stops it"
        )

    @property
    def claims(self) -> tuple[str, ...]:
        """The joints that the controller claims."""
        spec = self.spec
        if spec is None or (spec.interface is None and self.arm_mode is None):
            return ()
        return spec.joints

    @property
    def commands(self) -> bool:
        """Whether the controller has a command for each of its joints."""
        return bool(self.claims) and self.arm_mode is None

    @property
    def arm_mode(self) -> ArmModeSpec | None:
        """The parameters, if the controller represents freedrive or force mode."""
        return self.spec if isinstance(self.spec, ArmModeSpec) else None

    @property
    def held(self) -> tuple[str, ...]:
        """The joints that the controller currently drives."""
        is_idle = self.arm_mode is not None and self.effort_law is None
        return () if self.is_waiting or is_idle else self.claims

    @property
    def claimed(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The command interfaces that the controller claims, with their joints."""
        if self.arm_mode is not None:
            return ((self.arm_mode.mode, self.claims),)
        interface = self.interface
        return () if interface is None else ((interface.value, self.claims),)

    @property
    def command_interfaces(self) -> tuple[str, ...]:
        """The claimed command interfaces, with their names in ROS 2."""
        spec = self.spec
        if spec is None:
            return ()
        if self.interface is None:
            return spec.further_interfaces
        kind = self.interface.name.lower()
        names = (f"{joint}/{kind}" for joint in spec.joints)
        return (*names, *spec.further_interfaces)

    def started(self, state: JointState) -> Controller:
        """Return a new running instance of the controller."""
        return self.configured.start(self.indices, state)

    @property
    def configured(self) -> ControllerSpec:
        """The checked parameters.

        Raises:
            ControlError: If the controller is not configured.
        """
        if self.spec is None:
            raise ControlError(
                f"controller '{self.name}' is {self.state}; configure it with "
                f"`tool0 controllers configure {self.name}` or "
                f"robot.configure('{self.name}')"
            )
        return self.spec
