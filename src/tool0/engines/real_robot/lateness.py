"""Measures how late the network and both computers are, from when packages arrive."""

from __future__ import annotations

import math
from typing import Final, final

MEMORY: Final = 10.0
"""Time after which a late package is forgotten, or up to twice that [s]."""
DRIFT: Final = 1e-4
"""Largest difference of the two clocks' rates."""
MARGIN: Final = 0.025
"""Margin of a start delay, besides the lateness [s]: three periods of a CB3."""
MOST: Final = 0.2
"""Longest start delay [s]: knots are sent no longer before their time."""
_RESTART: Final = 1.0
"""A package that is later than that comes from a clock that was set [s]."""


@final
class Lateness:
    """Compares a robot's clock with ours; the soonest package counts as in time."""

    def __init__(self) -> None:
        self._least = math.inf
        """Least difference between the clocks [s]."""
        self._late = self._late_before = 0.0
        """Lateness of the latest package in this span of ``MEMORY``, and in the last
        one [s]."""
        self._since = self._last = 0.0
        """Times at which this span began, and at which the last package arrived [wall
        s]."""

    def observe(self, time: float, arrived: float) -> None:
        """Take a package into account, with the robot's and our time [s]."""
        difference = arrived - time
        if abs(difference - self._least) > _RESTART:
            self._least, self._late, self._late_before = difference, 0.0, 0.0
            self._since = self._last = arrived
        drift = DRIFT * (arrived - self._last)
        self._least = min(self._least + drift, difference)
        self._last = arrived
        if arrived - self._since > MEMORY:
            self._late, self._late_before, self._since = 0.0, self._late, arrived
        self._late = max(self._late, difference - self._least)

    @property
    def start_delay(self) -> float:
        """Time before its start at which a motion should be sent [s].

        What a tick sends is late by the way of the state to it, and by the way back.
        """
        return min(MARGIN + 2.0 * max(self._late, self._late_before), MOST)
