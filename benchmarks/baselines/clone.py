"""Behavior cloning with NumPy.  A small network predicts chunks of actions.

The method ``bc`` is the same as in ``examples/30_clone_expert.py``: three hidden
layers, Adam, and Huber's loss.  The method ``bc-fine`` has additional inputs, and
executes fewer actions of each chunk.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import gymnasium
import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray

from benchmarks.baselines.fine_inputs import FineInputs
from benchmarks.baselines.results import cpu_seconds, starts, write_run
from benchmarks.successes import Act, rate
from tool0.collect import collect

CHUNK = 10
"""Number of actions that one prediction contains.  ``bc`` executes all these actions
before the next prediction."""
FINE_CHUNK = 2
"""Number of actions of a prediction that ``bc-fine`` executes."""
WIDTH, LAYERS = 256, 3
BATCH, RATE = 256, 1e-3
BEND = 0.05
"""Error above which the loss grows linearly, as a fraction of half an action's
range."""

Array = NDArray[np.float32]
Inputs = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Function that returns the inputs of a network, shape (n, k), for states (n, m)."""


@dataclass(frozen=True)
class Clone:
    """A trained network."""

    inputs: Inputs
    executed: int
    """Number of actions of a prediction that are executed."""
    mean: NDArray[np.float64]
    spread: NDArray[np.float64]
    weights: list[Array]

    def __call__(self, states: NDArray[np.float64]) -> Array:
        """Return chunks of actions, shape (n, CHUNK, k), for states of shape (n, m)."""
        x = _normalised(self.inputs(states), self.mean, self.spread)
        return _layers(x, self.weights)[-1].reshape(len(states), CHUNK, -1)

    def begin(self, env: gymnasium.vector.VectorEnv) -> Act:
        """Return a function that executes the predictions from the first step."""
        rest: list[Array] = []

        def act(states: NDArray[np.float64]) -> Array:
            if not rest:
                rest.extend(np.swapaxes(self(states), 0, 1)[: self.executed])
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


def plain(states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the states, without additional inputs."""
    return states


def train(
    states: NDArray[np.float64],
    y: Array,
    steps: int,
    seed: int,
    *,
    inputs: Inputs = plain,
    executed: int = CHUNK,
) -> Clone:
    """Return a network that predicts ``y`` from ``inputs(states)``.

    The network is trained for ``steps`` steps.
    """
    rng = np.random.default_rng(seed)
    given = inputs(states)
    mean, spread = given.mean(axis=0), given.std(axis=0) + 1e-3
    x = _normalised(given, mean, spread)
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
    return Clone(inputs, executed, mean, spread, w)


def run(task: str, seed: int, given: argparse.Namespace) -> None:
    """Collect the expert's episodes, train on them, and evaluate the policy.

    All seeds learn from the same episodes.
    """
    folder = given.folder / "episodes" / task
    collect(task, given.episodes, folder, workers=1)
    collected = cpu_seconds()
    states, y = pairs(folder)
    is_fine = given.method == "bc-fine"
    inputs = FineInputs(_names(task)) if is_fine else plain
    executed = FINE_CHUNK if is_fine else CHUNK
    clone = train(states, y, given.steps, seed, inputs=inputs, executed=executed)
    trained = cpu_seconds()
    found = rate(task, starts(seed, given.evaluated), clone.begin, threads=1)
    row = {
        "method": given.method,
        "task": task,
        "seed": seed,
        "episodes": given.episodes,
        "actions": len(states),
        "steps": given.steps,
        **found.as_json(),
        "cpu_seconds": trained - collected,
    }
    write_run(given.folder, row)


def _names(task: str) -> Sequence[str]:
    """Return the names of the numbers in a state of a task."""
    env = gymnasium.make(f"tool0/{task}-v0")
    names: Sequence[str] = env.unwrapped.number_names.observations[""]
    env.close()
    return names


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
