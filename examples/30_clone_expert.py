"""Clone an expert with NumPy: collect, train, evaluate.  `pip install '.[collect]'`."""

import tempfile
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from tool0.collect import collect
from tool0.policy import RunOptions, evaluate

STEPS, CHUNK, WIDTH = 2500, 10, 256


def pairs(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return the states, and the expert's next ten actions for each state."""
    states, chunks = [], []
    for path in sorted(folder.glob("data/*/*.parquet")):
        table = pq.read_table(path, columns=["observation", "action"])
        actions = np.array(table["action"].to_pylist(), np.float32)
        rows = np.arange(len(actions))[:, None] + np.arange(CHUNK)
        states.append(np.array(table["observation"].to_pylist()))
        chunks.append(actions[rows.clip(max=len(rows) - 1)].reshape(len(rows), -1))
    return np.concatenate(states), np.concatenate(chunks)


def layers(x: np.ndarray, weights: list[np.ndarray]) -> list[np.ndarray]:
    """Return the values of a network's layers, with the input layer first."""
    values = [x]
    for matrix in weights[:-1]:
        values.append(np.maximum(values[-1] @ matrix, 0.0))
    return [*values, values[-1] @ weights[-1]]


if __name__ == "__main__":
    folder, rng = Path(tempfile.mkdtemp()) / "lift", np.random.default_rng(0)
    print(collect("Lift", 200, folder).n_frames, "actions of the expert")
    states, y = pairs(folder)
    mean, spread = states.mean(axis=0), states.std(axis=0) + 1e-3
    x = np.insert((states - mean) / spread, 0, 1.0, axis=1).astype(np.float32)
    ends = list(pairwise([x.shape[1], WIDTH, WIDTH, WIDTH, y.shape[1]]))
    w = [(2 / a) ** 0.5 * rng.standard_normal((a, b), np.float32) for a, b in ends]
    m, v = [0.0 * one for one in w], [0.0 * one for one in w]
    for n in range(STEPS):  # Adam optimizer
        rows = rng.integers(len(x), size=256)
        *values, found = layers(x[rows], w)
        slope = np.clip((found - y[rows]) / 0.05, -1.0, 1.0) / len(rows)
        for k in reversed(range(len(w))):
            g, slope = values[k].T @ slope, (slope @ w[k].T) * (values[k] > 0.0)
            m[k], v[k] = 0.9 * m[k] + 0.1 * g, 0.999 * v[k] + 0.001 * g * g
            w[k] -= 1e-3 * (1.0 - n / STEPS) * m[k] / (np.sqrt(v[k]) + 1e-8)

    def clone(s):
        return layers(np.insert((s - mean) / spread, 0, 1.0), w)[-1].reshape(CHUNK, -1)

    run = RunOptions(clips=True)
    report = evaluate(lambda seed: clone, "Lift", range(100_000, 100_050), run=run)
    print(f"success: {report.success_rate:.0%} of {report.n_episodes}")
