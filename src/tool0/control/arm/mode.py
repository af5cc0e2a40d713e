"""Controllers that represent an arm's freedrive and force mode.

The controllers send no commands to the joints.  Requests start and end the mode of a
controller.  While the mode is active, the arm's compliance law drives the joints
(``simulation/arms/controller_mode.py``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from tool0.control.passive import PassiveController
from tool0.description.model import Interface
from tool0.hardware.engine import JointState
from tool0.protocol.controllers import Gains


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ArmModeSpec:
    """The parameters of a controller for freedrive or force mode."""

    name: str
    type: str
    joints: tuple[str, ...]
    """Joints of the arm; other controllers cannot claim them while the controller for
    the mode is running."""
    companions: frozenset[str]
    """Types of the controllers that may share the joints.  These controllers command
    the nominal motion from which the compliant arm deviates."""
    is_freedrive: bool
    further_interfaces: tuple[str, ...]
    state_interfaces: tuple[str, ...] = ()

    interface: ClassVar[Interface | None] = None
    gains: ClassVar[tuple[Gains, ...]] = ()
    waits_for_command: ClassVar[bool] = False

    @property
    def mode(self) -> str:
        """The mode that the controller claims: ``freedrive_mode`` or ``force_mode``."""
        return "freedrive_mode" if self.is_freedrive else "force_mode"

    def start(self, indices: Sequence[int], state: JointState) -> PassiveController:
        """Return a controller; ``indices`` and ``state`` are not used."""
        del indices, state
        return PassiveController()
