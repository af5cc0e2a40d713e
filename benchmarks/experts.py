"""Success rates of the tasks' experts: ``python -m benchmarks.experts``.

Each episode starts with a different seed.  The intervals are Wilson's intervals at 95
%.
"""

from __future__ import annotations

import argparse

import tool0.gym
from benchmarks.successes import rate
from tool0.gym.tasks import TASKS

ROBOTS = (("ur5", "2f85"), ("ur5e", "hande"))
SEED = 5000


def main() -> None:
    """Print the success rates of some tasks or of all tasks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", default=list(TASKS))
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--randomise", action="store_true")
    arguments = parser.parse_args()
    for task in arguments.tasks:
        for arm, gripper in ROBOTS:
            found = rate(
                task,
                range(SEED, SEED + arguments.episodes),
                tool0.gym.expert,
                arm=arm,
                gripper=gripper,
                randomise=arguments.randomise,
            )
            low, high = found.interval
            print(
                f"{task:13} {arm:5} {gripper:6} {found.n_succeeded:4} of {found.n}: "
                f"{100.0 * found.n_succeeded / found.n:5.1f} % "
                f"({100.0 * low:.1f} … {100.0 * high:.1f} %), "
                f"{found.actions:.0f} actions",
                flush=True,
            )


if __name__ == "__main__":
    main()
