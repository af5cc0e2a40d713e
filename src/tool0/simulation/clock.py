"""Simulated time against the wall clock: times at which ticks are due, late ticks."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import final

CATCH_UP = 0.1
"""Wall time by which the simulation may lag behind and still catch up [s].

A larger lag is dropped, so that the robot does not race through hours that it missed
while the machine was suspended.
"""


@final
class Pacer:
    """Computes when the next tick is due, and counts late ticks."""

    def __init__(
        self,
        period: float,
        speed: float = 1.0,
        now: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Start now; ``period`` is in simulated [s], ``now`` returns wall time [s]."""
        self._wall_period = period / speed
        self._now = now
        self._due = now()
        self._late = 0.0
        self.overruns = 0

    def wait_time(self) -> float:
        """Return the wait until the next tick [wall s]; 0 or negative if it is due."""
        return self._due - self._now()

    def tick(self) -> int:
        """Record the start of the due tick; return how many are due, including it."""
        self._late = late = self._now() - self._due
        if late > CATCH_UP:
            self._due += late - CATCH_UP
        self._count()
        return 1 + int(max(0.0, min(late, CATCH_UP)) / self._wall_period)

    def tick_further(self, count: int) -> None:
        """Record that further ticks started together with the last one."""
        for _ in range(count):
            self._late -= self._wall_period
            self._count()

    def _count(self) -> None:
        if self._late > self._wall_period:
            self.overruns += 1
        self._due += self._wall_period


@final
class FollowedClock:
    """Pace of an engine that waits for its own clock in each step."""

    overruns = 0

    def wait_time(self) -> float:
        """Return 0, since the next tick is always due."""
        return 0.0

    def tick(self) -> int:
        """Return the number of due ticks, which is one."""
        return 1

    def tick_further(self, count: int) -> None:
        """Do nothing, since no tick of such an engine is late."""


@final
class SpeedMeter:
    """Measures simulated per wall time, and late ticks, over about the last second."""

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._overruns = 0
        self.factor = 0.0
        self.late_ticks = 0
        self.restart(0.0, 0)

    def restart(self, sim_time: float, overruns: int) -> None:
        """Start a window; earlier time, such as a pause, is ignored."""
        self._since = self._now(), sim_time
        self._overruns = overruns
        self.late_ticks = 0

    def measure(
        self, sim_time: float, overruns: int = 0, *, window: float = 1.0
    ) -> bool:
        """Take ``sim_time`` [s] and the late ticks since the start into account.

        Returns whether a window ended.
        """
        wall = self._now()
        since, start = self._since
        if sim_time < start:
            self.restart(sim_time, overruns)
            return False
        if wall - since < window:
            return False
        late_ticks = overruns - self._overruns
        self.restart(sim_time, overruns)
        self.factor = (sim_time - start) / (wall - since)
        self.late_ticks = late_ticks
        return True


BEHIND = 0.95
"""Fraction of the requested speed below which a second counts as slow."""
SLOW_WINDOWS = 3
"""Surplus of slow over other seconds after which the simulation is behind."""


@final
class Lag:
    """Whether the simulation is behind the wall clock; single hiccups do not count."""

    def __init__(self) -> None:
        self.is_behind = False
        self._n_slow = 0

    def changes(self, share: float) -> bool:
        """Take the achieved part of the speed; return whether ``is_behind`` changes."""
        step = 1 if share < BEHIND else -1
        self._n_slow = min(max(self._n_slow + step, 0), SLOW_WINDOWS)
        before = self.is_behind
        if self._n_slow in (0, SLOW_WINDOWS):
            self.is_behind = self._n_slow > 0
        return self.is_behind != before
