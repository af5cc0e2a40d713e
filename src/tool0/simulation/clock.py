"""Simulated time in relation to the wall clock: due times of ticks, and late ticks."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import final

CATCH_UP = 0.1
"""Longest lag behind wall time that the simulation tries to make up [s].

A larger lag is dropped, since the simulation would otherwise run at full speed through
the time that it missed while the computer was suspended.
"""


@final
class Pacer:
    """Computes the due time of the next tick, and counts late ticks."""

    def __init__(
        self,
        period: float,
        speed: float = 1.0,
        now: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Start with a tick that is due immediately.

        ``period`` is in simulated time [s], and ``now`` returns wall time [s].
        """
        self._wall_period = period / speed
        self._now = now
        self._due = now()
        self._late = 0.0
        self.overruns = 0

    def wait_time(self) -> float:
        """Return the wall time until the next tick [s].

        The result is 0 or negative if the tick is due.
        """
        return self._due - self._now()

    def tick(self) -> int:
        """Record the start of a due tick, and return the number of due ticks.

        The number includes the recorded tick.
        """
        self._late = late = self._now() - self._due
        if late > CATCH_UP:
            self._due += late - CATCH_UP
        self._count()
        return 1 + int(max(0.0, min(late, CATCH_UP)) / self._wall_period)

    def tick_further(self, count: int) -> None:
        """Record that additional ticks started together with the last tick."""
        for _ in range(count):
            self._late -= self._wall_period
            self._count()

    def _count(self) -> None:
        if self._late > self._wall_period:
            self.overruns += 1
        self._due += self._wall_period


@final
class FollowedClock:
    """Pacer for an engine that waits for its own clock in each step."""

    overruns = 0

    def wait_time(self) -> float:
        """Return 0, since the next tick is always due."""
        return 0.0

    def tick(self) -> int:
        """Return the number of due ticks, which is one."""
        return 1

    def tick_further(self, count: int) -> None:
        """Do nothing, since ticks of an engine with its own clock are never late."""


@final
class SpeedMeter:
    """Measures the ratio of simulated time to wall time, and counts late ticks.

    The measurement covers roughly the last second.
    """

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._overruns = 0
        self.factor = 0.0
        self.late_ticks = 0
        self.restart(0.0, 0)

    def restart(self, sim_time: float, overruns: int) -> None:
        """Start a measurement window; earlier time, such as a pause, is ignored."""
        self._since = self._now(), sim_time
        self._overruns = overruns
        self.late_ticks = 0

    def measure(
        self, sim_time: float, overruns: int = 0, *, window: float = 1.0
    ) -> bool:
        """Update the measurement with ``sim_time`` [s] and the total ``overruns``.

        The result is True if a measurement window ended.
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
"""Fraction of the requested speed below which a second is counted as slow."""
SLOW_WINDOWS = 3
"""Excess of slow seconds over other seconds at which the simulation is considered to be
falling behind."""


@final
class Lag:
    """Detects whether the simulation is behind the wall clock.

    Single short delays are ignored.
    """

    def __init__(self) -> None:
        self.is_behind = False
        self._n_slow = 0

    def changes(self, share: float) -> bool:
        """Update with the achieved fraction of the requested speed.

        The result is True if ``is_behind`` has changed.
        """
        step = 1 if share < BEHIND else -1
        self._n_slow = min(max(self._n_slow + step, 0), SLOW_WINDOWS)
        before = self.is_behind
        if self._n_slow in (0, SLOW_WINDOWS):
            self.is_behind = self._n_slow > 0
        return self.is_behind != before
