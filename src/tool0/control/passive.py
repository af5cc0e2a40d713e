"""Controllers that move no joints; the ROS node implements their ROS interfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from tool0.control.law import IdleLaw
from tool0.description.model import Interface
from tool0.hardware.engine import JointState
from tool0.protocol.controllers import Gains


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PassiveSpec:
    """The parameters of a controller that moves no joints."""

    name: str
    type: str
    state_interfaces: tuple[str, ...] = ()
    further_interfaces: tuple[str, ...] = ()

    joints: ClassVar[tuple[str, ...]] = ()
    interface: ClassVar[Interface | None] = None
    gains: ClassVar[tuple[Gains, ...]] = ()
    waits_for_command: ClassVar[bool] = False

    def start(self, indices: Sequence[int], state: JointState) -> PassiveController:
        """Return a controller; ``indices`` and ``state`` are not used."""
        del indices, state
        return PassiveController()


@final
class PassiveController:
    """A controller that does nothing in the tick."""

    pid: ClassVar[None] = None

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return no command."""
        return ()

    def law(self) -> IdleLaw:
        return IdleLaw()

    def observe(self, state: JointState) -> None:
        """Do nothing."""

    def setpoint(self) -> None:
        """Return None, since the controller commands no joints."""

    def stop(self) -> None:
        """Do nothing, since there is no goal to end."""
