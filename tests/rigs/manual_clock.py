"""A clock for tests without waiting."""

from __future__ import annotations


class ManualClock:
    """A clock that advances only when a test changes its time [s]."""

    def __init__(self) -> None:
        self.time = 100.0

    def __call__(self) -> float:
        return self.time
