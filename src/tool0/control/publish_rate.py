"""Timing of messages that are published at a fixed rate in simulated time."""

from __future__ import annotations

import math
from typing import final

_ROUNDING = 1e-9
"""Tolerance for differences between sums of periods and multiples of the tick [s]."""

_PAUSE = 0.5
"""Length of a pause after which missed publications are dropped, since the publisher
was not running [s]. ros_control drops missed publications at every start."""


@final
class PublishRate:
    """Rule of ros_control: publish once per period, and catch up on late messages."""

    def __init__(self, rate: float) -> None:
        """Set a rate [Hz]; with a rate of 0 or less, no messages are published."""
        self._period = 1.0 / rate if rate > 0.0 else math.inf
        self._last = self._checked = -math.inf

    def is_due(self, time: float) -> bool:
        """Return whether to publish at ``time`` [s].

        The first call returns True if the rate is positive.

        A message for each time is published only once, even if several snapshots have
        the same time.
        """
        if not math.isfinite(self._period) or time == self._checked:
            return False
        pause, self._checked = time - self._checked, time
        if pause < 0.0 or pause > max(_PAUSE, self._period):
            self._last = time
            return True
        if time < self._last + self._period - _ROUNDING:
            return False
        self._last += self._period
        return True
