"""How much faster two workers collect than one; run alone, it measures for the docs."""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from pathlib import Path

from tool0.collect import Progress, collect

N_EPISODES = 192
ROUNDS = 3


def rate(n_workers: int, n_episodes: int = N_EPISODES) -> float:
    """Return the episodes of Lift per second once all workers work [1 / wall s]."""
    marks: list[tuple[float, int]] = []

    def note(progress: Progress) -> None:
        marks.append((time.perf_counter(), progress.n_episodes))

    with tempfile.TemporaryDirectory() as folder:
        collect(
            *("Lift", n_episodes, Path(folder, "lift")),
            workers=n_workers,
            progress=note,
        )
    start, first = next(mark for mark in marks if mark[1])
    end, last = marks[-1]
    return (last - first) / (end - start)


def speed_ratio() -> float:
    """Return the rate of two workers ÷ that of one, which take turns."""
    return statistics.median(rate(2) / rate(1) for _ in range(ROUNDS))


if __name__ == "__main__":
    n_workers = int(sys.argv[1])
    print(f"{rate(n_workers):.2f} episodes/s with {n_workers} workers")
