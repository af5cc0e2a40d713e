"""Reinforcement learning with PPO and SAC from Stable-Baselines3.

Training uses physics steps of 2 ms, and many copies in one vector environment.  The
evaluation uses the unchanged task.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from examples.stable_baselines3.train_reach import Copies
from numpy.typing import NDArray
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

from benchmarks.baselines.results import cpu_seconds, starts, write_point, write_run
from benchmarks.successes import Act, rate

DT = 0.002
"""Physics step in training [s]."""
EVERY = 2_000
"""Number of actions between two points of a curve."""
METHODS: dict[str, tuple[type[BaseAlgorithm], int, dict[str, Any]]] = {
    "ppo": (
        PPO,
        32,
        {
            "n_steps": 32,
            "batch_size": 256,
            "learning_rate": 1e-3,
            "gamma": 0.95,
            "policy_kwargs": {"net_arch": [64, 64]},
        },
    ),
    "sac": (
        SAC,
        16,
        {
            "learning_starts": 3_000,
            "train_freq": 1,
            "gradient_steps": 4,
            "learning_rate": 1e-3,
            "gamma": 0.97,
            "tau": 0.01,
            "ent_coef": "auto_0.1",
            "policy_kwargs": {"net_arch": [128, 128]},
        },
    ),
}
"""The algorithm, the number of copies, and the algorithm's keyword arguments."""


class Curve(BaseCallback):
    """Writes the success rate and mean return of the last hundred episodes."""

    def __init__(self, folder: Path, run: tuple[str, str, int], first: int) -> None:
        """Write the curve of a run, which is given as (method, task, seed).

        The first point is written after ``first`` actions.
        """
        super().__init__()
        self._folder = folder
        self._run = run
        self._start = cpu_seconds()
        self._next = first

    def _on_step(self) -> bool:
        if self.num_timesteps >= self._next and self.model.ep_success_buffer:
            self._next += EVERY
            returned = np.mean([one["r"] for one in self.model.ep_info_buffer])
            write_point(
                self._folder,
                *self._run,
                self.num_timesteps,
                round(float(np.mean(self.model.ep_success_buffer)), 3),
                round(float(returned), 2),
                round(cpu_seconds() - self._start),
            )
        return True


def run(task: str, seed: int, given: argparse.Namespace) -> None:
    """Train on a task, and evaluate the deterministic policy."""
    torch.set_num_threads(1)
    algorithm, copies, keywords = METHODS[given.method]
    begun = cpu_seconds()
    many = Copies(f"tool0/{task}-v0", copies, dt=DT, threads=1)
    env = VecNormalize(VecMonitor(many), norm_reward=False)
    model = algorithm("MlpPolicy", env, seed=seed, device="cpu", **keywords)
    # Until every copy has ended an episode, the ended episodes are mainly successes, so
    # that the success rate is biased.
    first = max(EVERY, copies * many.env.spec.max_episode_steps)
    curve = Curve(given.folder, (given.method, task, seed), first)
    model.learn(given.actions, callback=curve)
    trained = cpu_seconds()
    env.close()

    def begin(evaluated: gymnasium.vector.VectorEnv) -> Act:
        def act(states: NDArray[np.float64]) -> NDArray[np.float32]:
            normal = env.normalize_obs(states)
            return model.predict(normal, deterministic=True)[0]

        return act

    found = rate(task, starts(seed, given.evaluated), begin, threads=1)
    row = {
        "method": given.method,
        "task": task,
        "seed": seed,
        "actions": model.num_timesteps,
        **found.as_json(),
        "cpu_seconds": trained - begun,
    }
    write_run(given.folder, row)
