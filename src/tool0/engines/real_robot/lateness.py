"""Measurement of package delays caused by the network and both computers."""

from __future__ import annotations

import math
from typing import Final, final

MEMORY: Final = 10.0
"""Time for which late packages are considered [s].  A late package is disregarded after
at most twice this time."""
DRIFT: Final = 1e-4
"""Largest relative difference between the two clocks' rates."""
MARGIN: Final = 0.025
"""Margin that is added to the lateness in a start delay [s].  The value is three
periods of a CB3."""
MOST: Final = 0.2
"""Longest start delay [s].  This delay limits how far in advance knots are sent."""
_RESTART: Final = 1.0
"""If the difference between the clocks changes by more than this value, a clock is
assumed to have been set [s]."""


@final
class Lateness:
    """Comparison of a robot's clock with this computer's clock.

    The package that was received earliest is considered to be on time.
    """

    def __init__(self) -> None:
        self._least = math.inf
        """Smallest measured difference between the clocks [s]."""
        self._late = self._late_before = 0.0
        """Largest lateness of a package in the current interval of length ``MEMORY``,
        and in the previous interval [s]."""
        self._since = self._last = 0.0
        """Time at which the current interval began, and time at which the last package
        was received [wall s]."""

    def observe(self, time: float, arrived: float) -> None:
        """Add a package with the robot's time and the local time of arrival [s]."""
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

        The lateness of a tick's commands is the sum of two delays: the delay of the
        state that the tick reads, and the delay of the commands on their way to the
        robot.
        """
        return min(MARGIN + 2.0 * max(self._late, self._late_before), MOST)
