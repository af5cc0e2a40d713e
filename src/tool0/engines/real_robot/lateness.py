"""Measures the lateness of the network and both computers from arrivals of packages."""

from __future__ import annotations

import math
from typing import Final, final

MEMORY: Final = 10.0
"""Time after which late packages are forgotten, at the latest after twice this time
[s]."""
DRIFT: Final = 1e-4
"""Largest relative difference between the two clocks' rates."""
MARGIN: Final = 0.025
"""Margin that is added to the lateness in a start delay [s]: three periods of a CB3."""
MOST: Final = 0.2
"""Longest start delay [s], which limits how early knots are sent."""
_RESTART: Final = 1.0
"""Lateness of a package above which a clock must have been set [s]."""


@final
class Lateness:
    """Compares a robot's clock with ours; the earliest package counts as on time."""

    def __init__(self) -> None:
        self._least = math.inf
        """Smallest difference between the clocks [s]."""
        self._late = self._late_before = 0.0
        """Largest lateness of a package in the present span of ``MEMORY``, and in the
        previous span [s]."""
        self._since = self._last = 0.0
        """Times at which the present span began, and at which the last package arrived
        [wall s]."""

    def observe(self, time: float, arrived: float) -> None:
        """Take a package into account: the robot's time and our time of arrival [s]."""
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
        """Time by which a motion should be sent before it starts [s].

        Commands of a tick are late by the delay of the state that it reads and by the
        delay of their own way to the robot.
        """
        return min(MARGIN + 2.0 * max(self._late, self._late_before), MOST)
