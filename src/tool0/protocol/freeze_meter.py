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
class Activity:
    """The last activity of a process and its last freeze, for meters in any thread.

    There is no lock, which a fork could copy while a thread holds it.  At worst, two
    threads count the same freeze.
    """

    def __init__(
        self,
        now: Callable[[], float] = wall_time,
        processor_time: Callable[[], float] = time.process_time,
        frozen: float = FROZEN,
    ) -> None:
        self._now, self._processor_time, self._frozen = now, processor_time, frozen
        self._last = self._sampled = now()
        self._used = processor_time()
        self.n_freezes = 0
        self.duration = 0.0
        """Duration of the last freeze [wall s]."""

    def record(self, *, samples: bool = False) -> None:
        """Record that the calling thread runs, and whether this ends a freeze.

        With ``samples``, read the processor time in any case.
        """
        now = self._now()
        gap = now - self._last
        if gap <= 0.0:  # another thread has recorded a later time
            return
        self._last = now
        if gap < self._frozen and now - self._sampled < _SAMPLING and not samples:
            return
        before, self._used = self._used, self._processor_time()
        self._sampled = now
        if gap >= self._frozen and self._used - before < _BUSY * gap:
            self.duration = gap
            self.n_freezes += 1


_THIS_PROCESS = Activity()


@final
class FreezeMeter:
    """Detects that the whole process was stopped, or that the machine slept.

    The delay of a thread is ignored if the process was busy, or if the thread of
    another meter was not delayed.
    """

    def __init__(self, activity: Activity = _THIS_PROCESS) -> None:
        self._activity = activity
        # A freeze before this moment is not reported, and the processor time of a
        # parent process is not counted.
        activity.record(samples=True)
        self._n_freezes = activity.n_freezes

    def look(self) -> float:
        """Return the time for which the process was frozen since the last call [s]."""
        self._activity.record()
        before, self._n_freezes = self._n_freezes, self._activity.n_freezes
        return self._activity.duration if self._n_freezes != before else 0.0
