"""How often something is published, in simulated time."""

from __future__ import annotations

import math
from typing import final

_ROUNDING = 1e-9
"""[s], by which sums of periods differ from multiples of the tick."""


@final
class PublishRate:
    """ros_control's rule: due once a period has passed; late ones are caught up."""

    def __init__(self, rate: float) -> None:
        """Take a rate [Hz]; 0 or less is never."""
        self._period = 1.0 / rate if rate > 0.0 else math.inf
        self._last = -math.inf

    def is_due(self, time: float) -> bool:
        """Return whether to publish at ``time`` [s]; the first time always."""
        if not math.isfinite(self._period):
            return False
        if time < self._last or self._last == -math.inf:
            self._last = time
            return True
        if time < self._last + self._period - _ROUNDING:
            return False
        self._last += self._period
        return True
