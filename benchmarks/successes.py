"""Measures the success rate of a policy, with many parallel episodes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import tool0.gym  # noqa: F401  # registers the tasks
from tool0.policy.report import wilson

COPIES = 10
"""Number of parallel episodes.  All episodes continue until the last episode ends."""

Act = Callable[[NDArray[np.float64]], NDArray[np.floating]]
"""Function that returns actions (n, k) for observations (n, m)."""


@dataclass(frozen=True)
class Rate:
    """Successes in n episodes."""

    n: int
    n_succeeded: int
    actions: float
    """Mean number of actions of the successful episodes; NaN if there are none."""

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's interval of the success rate at 95 %."""
        return wilson(self.n_succeeded, self.n)

    def as_json(self) -> dict[str, Any]:
        """Return the results as plain values."""
        return {
            "evaluated": self.n,
            "succeeded": self.n_succeeded,
            "interval": self.interval,
            "mean_actions": self.actions if self.n_succeeded else None,
        }


def rate(
    task: str,
    seeds: range,
    policy: Callable[[gymnasium.vector.VectorEnv], Act],
    **options: object,
) -> Rate:
    """Return the successes of a policy in a task, with one episode for each seed.

    Args:
        task: Name of the task, such as ``Lift``.
        seeds: Seeds of the episodes, without gaps.
        policy: Function that returns a policy, which is a function from observations to
            actions.  The function is called with an environment before the
            environment's episodes begin.
        options: Keyword arguments of the environment.
    """
    steps: list[int] = []
    for first in seeds[::COPIES]:
        count = min(COPIES, seeds.stop - first)
        env = gymnasium.make_vec(
            f"tool0/{task}-v0",
            num_envs=count,
            autoreset_mode="Disabled",
            terminate_on_success=False,
            **options,
        )
        act = policy(env)
        observed, _ = env.reset(seed=first)
        ended, step = np.zeros(count, dtype=bool), 0
        while not ended.all():
            observed, _, _, truncated, info = env.step(act(observed))
            step += 1
            steps += [step] * int((info["is_success"] & ~ended).sum())
            ended |= info["is_success"] | truncated
            if truncated.any():
                env.reset(options={"reset_mask": truncated})
        env.close()
    return Rate(len(seeds), len(steps), float(np.mean(steps)) if steps else math.nan)
