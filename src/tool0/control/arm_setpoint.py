"""The setpoint of an arm: one motion that is continuous from mode to mode."""

from __future__ import annotations

from typing import Protocol

from tool0.protocol.state import ArmSetpoint


class StreamedMotion(Protocol):
    """A mode that Python executes tick by tick: it has no law."""

    @property
    def setpoint(self) -> ArmSetpoint:
        """The motion at the end of the last tick."""

    def advance(self, time: float, period: float, speed_scaling: float) -> None:
        """Move the setpoint on by one tick, which starts at ``time`` [s].

        ``speed_scaling`` is the control box's factor, 0 … 1.
        """
