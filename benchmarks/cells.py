"""Measures the start-up time and the speed of several robots in one cell."""

from __future__ import annotations

import statistics

import tool0
from benchmarks import process, tick

N_ROBOTS = 8
ROBOTS = tuple(f"robot{k}=ur5+2f85@{k % 4},{k // 4},0" for k in range(N_ROBOTS))
TWO = ("left=ur5+2f85@0,0.6,0", "right=ur5+2f85@0,-0.6,0")
ROUNDS = 5


def start_ratio() -> float:
    """Return the ratio of bring-up times of eight arms and of one arm.

    All arms have grippers.  The time is measured from the start to the end of the
    bring-up.
    """
    eight = [*process.BRINGUP, "--robots", *ROBOTS]
    process.cost(eight)  # compiles the bytecode
    pairs = [
        (process.cost(eight), process.cost(process.BRINGUP)) for _ in range(ROUNDS)
    ]
    return statistics.median(many.seconds / one.seconds for many, one in pairs)


def speed_ratio(robots: tuple[str, ...], *, moving: bool) -> float:
    """Return the steps/s of several robots, divided by those of ``mj_step``."""
    return tick.speed_ratio(
        moving=moving, description=tool0.DescriptionConfig(robots=robots)
    )


if __name__ == "__main__":
    for robots in (TWO, ROBOTS):
        for moving in (False, True):
            ratio = speed_ratio(robots, moving=moving)
            state = "moving" if moving else "holding"
            print(f"{len(robots)} robots: steps/s ÷ raw mj_step, {state}: {ratio:.3f}")
