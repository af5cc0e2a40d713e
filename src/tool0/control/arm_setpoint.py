"""The setpoint of an arm: one motion that is continuous from mode to mode."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol


class ArmSetpoint(NamedTuple):
    """The commanded motion of an arm's joints at an instant, base to flange."""

    positions: Sequence[float]
    """[rad]"""
    velocities: Sequence[float]
    """In simulated time [rad/s]."""
    accelerations: Sequence[float]
    """[rad/s²]"""

    @property
    def is_at_rest(self) -> bool:
        """Whether no joint moves."""
        return not any(self.velocities)

    @staticmethod
    def resting(positions: Sequence[float]) -> ArmSetpoint:
        """Return the setpoint of resting at ``positions`` [rad]."""
        zeros = (0.0,) * len(positions)
        return ArmSetpoint(tuple(positions), zeros, zeros)


class StreamedMotion(Protocol):
    """A mode that Python executes tick by tick: it has no law."""

    @property
    def setpoint(self) -> ArmSetpoint:
        """The motion at the end of the last tick."""

    def advance(self, time: float, period: float, speed_scaling: float) -> None:
        """Move the setpoint on by one tick, which starts at ``time`` [s].

        ``speed_scaling`` is the control box's factor, 0 … 1.
        """
