"""What several robots in one cell cost: start-up and steps."""

from __future__ import annotations

import statistics

import tool0
from benchmarks import process, tick

N_ROBOTS = 8
ROBOTS = tuple(f"robot{k}=ur5+2f85@{k % 4},{k // 4},0" for k in range(N_ROBOTS))
ROUNDS = 5


def start_ratio() -> float:
    """Return start to end of a bring-up of eight arms with grippers ÷ that of one."""
    eight = [*process.BRINGUP, "--robots", *ROBOTS]
    process.cost(eight)  # byte-compiles
    pairs = [
        (process.cost(eight), process.cost(process.BRINGUP)) for _ in range(ROUNDS)
    ]
    return statistics.median(many.seconds / one.seconds for many, one in pairs)


def speed_ratio() -> float:
    """Return simulated steps/s of eight arms that hold ÷ raw ``mj_step``."""
    return tick.speed_ratio(
        moving=False, description=tool0.DescriptionConfig(robots=ROBOTS)
    )
