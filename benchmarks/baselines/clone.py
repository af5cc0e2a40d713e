"""Behavior cloning with NumPy.  A small network predicts chunks of actions.

The method is the same as in ``examples/30_clone_expert.py``: three hidden layers, Adam,
and Huber's loss.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import gymnasium
import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray

from benchmarks.baselines.results import cpu_seconds, starts, write_run
from benchmarks.successes import Act, rate
from tool0.collect import collect

CHUNK = 10
"""Number of actions that one prediction contains.  All these actions are executed
before the next prediction."""
WIDTH, LAYERS = 256, 3
BATCH, RATE = 256, 1e-3
BEND = 0.05
"""Error above which the loss grows linearly, as a fraction of half an action's
range."""

Array = NDArray[np.float32]


@dataclass(frozen=True)
class Clone:
    """A trained network."""

    mean: NDArray[np.float64]
    spread: NDArray[np.float64]
    weights: list[Array]

    def __call__(self, states: NDArray[np.float64]) -> Array:
        """Return chunks of actions, shape (n, CHUNK, k), for states of shape (n, m)."""
        x = _normalised(states, self.mean, self.spread)
        return _layers(x, self.weights)[-1].reshape(len(states), CHUNK, -1)

    def begin(self, env: gymnasium.vector.VectorEnv) -> Act:
        """Return a function that executes whole chunks, from the first step."""
        rest: list[Array] = []

        def act(states: NDArray[np.float64]) -> Array:
            if not rest:
                rest.extend(np.swapaxes(self(states), 0, 1))
            return rest.pop(0).clip(-1.0, 1.0)

        return act


def pairs(folder: Path) -> tuple[NDArray[np.float64], Array]:
    """Return the states of a data set, and the chunk of actions after each state."""
    states, chunks = [], []
    for path in sorted(folder.glob("data/*/*.parquet")):
        table = pq.read_table(path, columns=["observation", "action"])
        actions = np.array(table["action"].to_pylist(), np.float32)
        rows = np.arange(len(actions))[:, None] + np.arange(CHUNK)
        states.append(np.array(table["observation"].to_pylist()))
        chunks.append(actions[rows.clip(max=len(rows) - 1)].reshape(len(rows), -1))
    return np.concatenate(states), np.concatenate(chunks)


def train(states: NDArray[np.float64], y: Array, steps: int, seed: int) -> Clone:
    """Return a network that predicts ``y`` from ``states``.

    The network is trained for ``steps`` steps.
    """
    rng = np.random.default_rng(seed)
    mean, spread = states.mean(axis=0), states.std(axis=0) + 1e-3
    x = _normalised(states, mean, spread)
    ends = list(pairwise([x.shape[1], *[WIDTH] * LAYERS, y.shape[1]]))
    w = [(2 / a) ** 0.5 * rng.standard_normal((a, b), np.float32) for a, b in ends]
    m, v = [0.0 * one for one in w], [0.0 * one for one in w]
    for n in range(steps):  # Adam, with a rate that decreases to 0
        rows = rng.integers(len(x), size=BATCH)
        *values, found = _layers(x[rows], w)
        slope = np.clip((found - y[rows]) / BEND, -1.0, 1.0) / BATCH
        for k in reversed(range(len(w))):
            g, slope = values[k].T @ slope, (slope @ w[k].T) * (values[k] > 0.0)
            m[k], v[k] = 0.9 * m[k] + 0.1 * g, 0.999 * v[k] + 0.001 * g * g
            w[k] -= RATE * (1.0 - n / steps) * m[k] / (np.sqrt(v[k]) + 1e-8)
    return Clone(mean, spread, w)


def run(task: str, seed: int, given: argparse.Namespace) -> None:
    """Collect the expert's episodes, train on them, and evaluate the policy.

    All seeds learn from the same episodes.
    """
    folder = given.folder / "episodes" / task
    collect(task, given.episodes, folder, workers=1)
    collected = cpu_seconds()
    states, y = pairs(folder)
    clone = train(states, y, given.steps, seed)
    trained = cpu_seconds()
    found = rate(task, starts(seed, given.evaluated), clone.begin, threads=1)
    row = {
        "method": "bc",
        "task": task,
        "seed": seed,
        "episodes": given.episodes,
        "actions": len(states),
        "steps": given.steps,
        **found.as_json(),
        "cpu_seconds": trained - collected,
    }
    write_run(given.folder, row)


def _normalised(
    states: NDArray[np.float64], mean: NDArray[np.float64], spread: NDArray[np.float64]
) -> Array:
    """Return the inputs of the network: normalized states, and a 1 for the bias."""
    return np.insert((states - mean) / spread, 0, 1.0, axis=1).astype(np.float32)


def _layers(x: Array, weights: list[Array]) -> list[Array]:
    """Return the values of a network's layers, with the input layer first."""
    values = [x]
    for matrix in weights[:-1]:
        values.append(np.maximum(values[-1] @ matrix, 0.0))
    return [*values, values[-1] @ weights[-1]]
