"""Measures how much faster two workers collect episodes than one worker."""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path

from tool0.collect import collect

SHORT, LONG = 48, 240
"""Numbers of episodes of two collections.  The difference of their times does not
include the start of the workers."""
ROUNDS = 3


def seconds(n_workers: int, n_episodes: int) -> float:
    """Return the time that collecting episodes of Lift takes [wall s]."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        collect("Lift", n_episodes, Path(folder, "lift"), workers=n_workers)
        return time.perf_counter() - start


def rate(n_workers: int) -> float:
    """Return the episodes per second of workers that have started [1 / wall s]."""
    return (LONG - SHORT) / (seconds(n_workers, LONG) - seconds(n_workers, SHORT))


def speed_ratio() -> float:
    """Return the rate of two workers divided by the rate of one worker.

    The measurements with one worker and with two workers alternate.
    """
    return statistics.median(rate(2) / rate(1) for _ in range(ROUNDS))


if __name__ == "__main__":
    print(f"episodes/s of two workers ÷ those of one: {speed_ratio():.2f}")
