"""Controllers in whose name an arm gives way: freedrive, and force mode.

The controller itself commands nothing: requests start and end its mode, and the arm's
law of compliance then drives the joints (``simulation/arms/controller_mode.py``).
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
    """The parameters of such a controller."""

    name: str
    type: str
    joints: tuple[str, ...]
    """The joints of its arm, which other controllers may not have meanwhile."""
    companions: frozenset[str]
    """Types of the controllers that may: what they command is the motion from which the
    arm deviates."""
    is_freedrive: bool
    further_interfaces: tuple[str, ...]
    state_interfaces: tuple[str, ...] = ()

    interface: ClassVar[Interface | None] = None
    gains: ClassVar[tuple[Gains, ...]] = ()
    waits_for_command: ClassVar[bool] = False

    @property
    def mode(self) -> str:
        """The hardware that it claims: ``freedrive_mode`` or ``force_mode``."""
        return "freedrive_mode" if self.is_freedrive else "force_mode"

    def start(self, indices: Sequence[int], state: JointState) -> PassiveController:
        """Return a controller; joints and state do not matter."""
        del indices, state
        return PassiveController()
