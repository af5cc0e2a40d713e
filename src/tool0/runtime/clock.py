"""Simulated time against the wall clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import final

CATCH_UP = 0.1
"""Wall time that the simulation may lag behind and still catch up [s].

What is lost beyond it is given up, so that a machine that slept does not come back to
a robot that races through the missed hours.
"""


@final
class Pacer:
    """Says when the next tick is due, and counts those that came too late."""

    def __init__(
        self,
        period: float,
        speed: float = 1.0,
        now: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Begin now.

        Args:
            period: Simulated time of a tick [s].
            speed: Simulated seconds per wall second.
            now: The wall clock [s].
        """
        self._wall_period = period / speed
        self._now = now
        self._due = now()
        self.overruns = 0

    def wait_time(self) -> float:
        """Return how long to wait for the next tick [wall s]; at most 0 if due."""
        return self._due - self._now()

    def tick(self) -> None:
        """Note that the tick that was due begins now."""
        late = self._now() - self._due
        if late > self._wall_period:
            self.overruns += 1
        if late > CATCH_UP:
            self._due += late - CATCH_UP
        self._due += self._wall_period


@final
class SpeedMeter:
    """Measures simulated per wall time over about the last second."""

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._since = now(), 0.0
        self.factor = 0.0

    def measure(self, sim_time: float, *, window: float = 1.0) -> bool:
        """Take ``sim_time`` [s] into account; return whether a window ended."""
        wall = self._now()
        since, start = self._since
        if sim_time < start or wall - since < window:
            if sim_time < start:
                self._since = wall, sim_time
            return False
        self.factor = (sim_time - start) / (wall - since)
        self._since = wall, sim_time
        return True
