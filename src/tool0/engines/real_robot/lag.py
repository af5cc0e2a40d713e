"""Measurement of a moving robot's lag behind its setpoints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

MEMORY: Final = 2.0
"""Time constant with which the weight of measurements decreases [s].  Only the time in
motion is counted."""
SLOW: Final = 0.05
"""Speed below which the lag of an arm cannot be measured [rad/s]."""
MOST: Final = 0.08
"""Largest lag or lead that is compensated [s]."""
ENOUGH: Final = 0.2
"""Shortest duration of motion for a measurement [s]."""


@final
class LagMeter:
    """Estimator of the joints' delay behind their setpoints.

    The delay is the least-squares solution sum(v e) / sum(v²), where v are the
    velocities of the setpoints and e are the distances of the joints from their
    setpoints.
    """

    def __init__(self, period: float) -> None:
        """Start without data; ``period`` is the time between two measurements [s]."""
        self._keep = 1.0 - period / MEMORY
        self._period = period
        self._products = self._squares = self._seen = 0.0

    def observe(
        self,
        wanted: Sequence[float],
        velocities: Sequence[float],
        measured: Sequence[float],
    ) -> None:
        """Add a setpoint and the state that was measured at the setpoint's time."""
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
        """Return the delay to compensate for [s], and begin a new measurement."""
        if self._seen < ENOUGH:
            return 0.0
        lag = self._products / self._squares
        self._products = self._squares = self._seen = 0.0
        return lag
