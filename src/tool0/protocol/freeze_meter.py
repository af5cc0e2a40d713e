"""Detection of times in which the process was stopped or the machine slept."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import final

FROZEN = 1.0
"""Wall time without activity after which a process is regarded as frozen [s]."""
_BUSY = 0.5
"""Ratio of processor time to wall time above which the process is regarded as busy,
rather than frozen."""
_SAMPLING = 0.2
"""Minimum wall time between two reads of the processor time [s]; these reads are
slow."""


def wall_time() -> float:
    """Return a time that also advances while the process or the machine sleeps [s]."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


@final
class FreezeMeter:
    """Detects that the whole process was stopped, or that the machine slept.

    The delay of a thread is ignored if other threads of the process were busy.
    """

    def __init__(
        self,
        now: Callable[[], float] = wall_time,
        processor_time: Callable[[], float] = time.process_time,
    ) -> None:
        self._now, self._processor_time = now, processor_time
        self._last = self._sampled = now()
        self._used = processor_time()

    def look(self) -> float:
        """Return the time for which the process was frozen since the last call [s]."""
        now = self._now()
        gap, self._last = now - self._last, now
        if gap < FROZEN and now - self._sampled < _SAMPLING:
            return 0.0
        before, self._used = self._used, self._processor_time()
        self._sampled = now
        is_frozen = gap >= FROZEN and self._used - before < _BUSY * gap
        return gap if is_frozen else 0.0
