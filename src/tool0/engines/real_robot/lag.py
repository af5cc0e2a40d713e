"""Measures a robot's lag behind its setpoints while it moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

MEMORY: Final = 2.0
"""Time constant, in time of motion, with which measurements lose weight [s]."""
SLOW: Final = 0.05
"""Speed below which an arm's lag cannot be measured [rad/s]."""
MOST: Final = 0.08
"""Largest lag or lead that is compensated [s]."""
ENOUGH: Final = 0.2
"""Duration of motion that a measurement needs [s]."""


@final
class LagMeter:
    """Finds the delay that explains the joints' distances from their setpoints.

    It is the least-squares solution sum(v e) / sum(v²), with the setpoints' velocities
    v and the distances e.
    """

    def __init__(self, period: float) -> None:
        """Start without data; ``period`` is the time between measurements [s]."""
        self._keep = 1.0 - period / MEMORY
        self._period = period
        self._products = self._squares = self._seen = 0.0

    def observe(
        self,
        wanted: Sequence[float],
        velocities: Sequence[float],
        measured: Sequence[float],
    ) -> None:
        """Take a setpoint and the state measured at its time into account."""
        squares = sum(v * v for v in velocities)
        if squares < SLOW * SLOW:
            return
        errors = zip(velocities, wanted, measured, strict=True)
        self._products = self._keep * self._products + sum(
            v * (q - p) for v, q, p in errors
        )
        self._squares = self._keep * self._squares + squares
        self._seen += self._period

    def take(self) -> float:
        """Return the delay to compensate [s], and begin a new measurement."""
        if self._seen < ENOUGH:
            return 0.0
        lag = self._products / self._squares
        self._products = self._squares = self._seen = 0.0
        return lag
