"""Timing of messages at a given rate, in simulated time."""

from __future__ import annotations

import math
from typing import final

_ROUNDING = 1e-9
"""Tolerance for differences between sums of periods and multiples of the tick [s]."""

_PAUSE = 0.5
"""Pause after which missed publications are dropped, since the publisher did not run
[s]. ros_control drops them at every start."""


@final
class PublishRate:
    """ros_control's rule: publish once per period, and catch up on late messages."""

    def __init__(self, rate: float) -> None:
        """Take a rate [Hz]; 0 or less means never."""
        self._period = 1.0 / rate if rate > 0.0 else math.inf
        self._last = self._checked = -math.inf

    def is_due(self, time: float) -> bool:
        """Return whether to publish at ``time`` [s]; True on the first call.

        Each time is published only once, even if several snapshots have the same time.
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
