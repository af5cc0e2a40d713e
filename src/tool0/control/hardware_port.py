"""The port to the robot's hardware, as the controller manager needs it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from tool0.description.model import Interface
from tool0.hardware.joint_state import JointState


class HardwarePort(Protocol):
    """Joints that controllers claim and command; a brake holds all others."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """All movable joints, in the engine's order."""

    @property
    def index(self) -> Mapping[str, int]:
        """Where each joint stands in that order."""

    @property
    def interfaces(self) -> Mapping[str, Interface]:
        """The joints that have a transmission, with their command interface."""

    @property
    def command(self) -> list[float]:
        """One slot per joint, in the engine's order, for the manager to write."""

    def claim(self, joints: Sequence[str], state: JointState) -> None:
        """Open the brake of ``joints``; their slots hold a safe first command."""

    def release(self, joints: Sequence[str], state: JointState) -> None:
        """Let the brake hold ``joints`` where ``state`` measures them."""
