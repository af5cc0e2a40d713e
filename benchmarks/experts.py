"""How often the experts of the tasks succeed: ``python -m benchmarks.experts``.

Each episode starts from a seed of its own.  Intervals are Wilson's, at 95 %.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass

import gymnasium
import numpy as np

import tool0.gym
from tool0.gym.tasks import TASKS

ROBOTS = (("ur5", "2f85"), ("ur5e", "hande"))
SEED = 5000
COPIES = 100
"""Episodes at once."""
Z = 1.959964
"""Quantile of the normal distribution, for 95 %."""


@dataclass(frozen=True)
class Rate:
    """Successes of n episodes."""

    n: int
    n_succeeded: int
    actions: float
    """Mean number of actions of those that succeeded."""

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's interval of the rate, at 95 %."""
        n, p = self.n, self.n_succeeded / self.n
        middle = p + Z * Z / (2.0 * n)
        half = Z * math.sqrt(p * (1.0 - p) / n + Z * Z / (4.0 * n * n))
        whole = 1.0 + Z * Z / n
        return max(0.0, (middle - half) / whole), min(1.0, (middle + half) / whole)


def rate(task: str, n: int, arm: str, gripper: str, *, randomise: bool = False) -> Rate:
    """Return how many of n episodes with seeds from SEED on succeed."""
    steps: list[int] = []
    for first in range(0, n, COPIES):
        count = min(COPIES, n - first)
        env = gymnasium.make_vec(
            f"tool0/{task}-v0",
            num_envs=count,
            autoreset_mode="Disabled",
            terminate_on_success=False,
            arm=arm,
            gripper=gripper,
            randomise=randomise,
        )
        act = tool0.gym.expert(env)
        observed, info = env.reset(seed=SEED + first)
        done = np.zeros(count, dtype=bool)
        for step in range(1, env.spec.max_episode_steps):
            observed, _, _, _, info = env.step(act(observed))
            fresh = info["is_success"] & ~done
            steps += [step] * int(fresh.sum())
            done |= fresh
            if done.all():
                break
        env.close()
    return Rate(n, len(steps), float(np.mean(steps)) if steps else math.nan)


def main() -> None:
    """Print the rates of some tasks, or of all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", default=list(TASKS))
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--randomise", action="store_true")
    arguments = parser.parse_args()
    for task in arguments.tasks:
        for arm, gripper in ROBOTS:
            found = rate(
                task,
                arguments.episodes,
                arm,
                gripper,
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
