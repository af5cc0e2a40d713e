"""How late the network and both computers are, from when packages arrive."""

from __future__ import annotations

import math
from typing import Final, final

MEMORY: Final = 5.0
"""In which a late package is forgotten [s]."""
DRIFT: Final = 1e-4
"""Largest difference of the two clocks' rates."""
MARGIN: Final = 0.025
"""Of a start delay, besides the lateness [s]: three periods of a CB3."""
MOST: Final = 0.15
"""Longest start delay [s]: the knots that are sent with a start go 0.2 s ahead."""
_RESTART: Final = 1.0
"""A package that is later than that comes from a clock that was set [s]."""


@final
class Lateness:
    """Compares a robot's clock with ours; the soonest package counts as in time."""

    def __init__(self) -> None:
        self._least = math.inf
        """Of the differences between the clocks [s]."""
        self._late = 0.0
        """Of the latest package, which is forgotten slowly [s]."""
        self._last = 0.0
        """When the last package arrived [wall s]."""

    def observe(self, time: float, arrived: float) -> None:
        """Take a package into account, with the robot's and our time [s]."""
        elapsed, self._last = arrived - self._last, arrived
        difference = arrived - time
        if abs(difference - self._least) > _RESTART:
            self._least, self._late = difference, 0.0
        self._least = min(self._least + DRIFT * elapsed, difference)
        self._late *= math.exp(-elapsed / MEMORY)
        self._late = max(self._late, difference - self._least)

    @property
    def start_delay(self) -> float:
        """How long before its start a motion should be sent [s].

        What a tick sends is late by the way of the state to it, and by the way back.
        """
        return min(MARGIN + 2.0 * self._late, MOST)
