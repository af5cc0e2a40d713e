"""The baselines: clones, how they are evaluated, and the table of their runs."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import gymnasium
import numpy as np
import pytest
from benchmarks.baselines import clone
from benchmarks.baselines.fine_inputs import SCALES, FineInputs
from benchmarks.baselines.results import curves, starts, table, write_point, write_run
from benchmarks.successes import rate

from tool0.collect import collect
from tool0.policy import RunOptions, evaluate

pytestmark = pytest.mark.slow

SEEDS = starts(0, 20)
SHORT = {"max_episode_steps": 40}
Data = tuple[np.ndarray, np.ndarray]
QUAT = ("qw", "qx", "qy", "qz")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Data:
    folder = tmp_path_factory.mktemp("reach")
    collect("Reach", 20, folder, workers=1)
    return clone.pairs(folder)


@pytest.fixture(scope="module")
def reaching(data: Data) -> clone.Clone:
    return clone.train(*data, steps=100, seed=0)


def test_a_clone_acts_like_the_expert(data: Data, reaching: clone.Clone) -> None:
    states, chunks = data
    error = np.abs(reaching(states).reshape(chunks.shape) - chunks).mean()
    assert error < 0.3 * np.abs(chunks - chunks.mean(axis=0)).mean()


def test_episodes_at_once_are_those_of_policy_run(reaching: clone.Clone) -> None:
    at_once = rate("Reach", SEEDS, reaching.begin, **SHORT)
    one_by_one = evaluate(
        lambda seed: lambda state: reaching(state[None])[0],
        "Reach",
        SEEDS,
        options=SHORT,
        run=RunOptions(clips=True),
    )
    assert 0 < at_once.n_succeeded < len(SEEDS)  # this clone has learned little
    assert at_once.n_succeeded == one_by_one.n_succeeded
    assert at_once.interval == one_by_one.interval


def test_fine_inputs_show_a_millimeter_and_a_small_angle() -> None:
    quats = [f"{body}.{part}" for body in ("tcp", "peg") for part in QUAT]
    inputs = FineInputs([*quats, "tcp_to_peg.x", "wrench.fx"])
    yaw = 0.01
    turned = [np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0)]
    state = np.array([[1.0, 0.0, 0.0, 0.0, *turned, 0.001, 5.0]])
    found = inputs(state)[0]
    np.testing.assert_array_equal(found[: state.size], state[0])
    distances, angles = np.split(found[state.size :], [len(SCALES)])
    np.testing.assert_allclose(distances, np.tanh(0.001 / np.array(SCALES)))
    one, four = -yaw, -4.0 * yaw
    expected = [np.sin(one), np.cos(one), np.sin(four), np.cos(four)]
    np.testing.assert_allclose(angles[:4], expected, atol=1e-12)
    assert angles[4] < -0.6


def test_a_clone_executes_the_beginning_of_each_prediction(data: Data) -> None:
    one = clone.train(*data, steps=1, seed=0, executed=1)
    states = data[0][:3]
    act = one.begin(cast(gymnasium.vector.VectorEnv, None))
    for _ in range(2):
        expected = one(states)[:, 0].clip(-1.0, 1.0)
        np.testing.assert_array_equal(act(states), expected)
        states = states[::-1]


def test_a_policy_that_rests_reaches_nothing() -> None:
    found = rate(
        "Reach", starts(0, 4), lambda env: lambda state: np.zeros((len(state), 5))
    )
    assert (found.n, found.n_succeeded) == (4, 0)
    assert np.isnan(found.actions)


def test_runs_become_rows_of_a_table(tmp_path: Path) -> None:
    row = {"method": "bc", "task": "Lift", "evaluated": 100, "actions": 5000}
    write_run(tmp_path, {**row, "seed": 0, "succeeded": 10, "cpu_seconds": 1.0})
    write_run(tmp_path, {**row, "seed": 0, "succeeded": 90, "cpu_seconds": 60.0})
    write_run(tmp_path, {**row, "seed": 1, "succeeded": 80, "cpu_seconds": 120.0})
    last = table(tmp_path).splitlines()[-1]
    assert last.startswith("| Lift | BC | 90%, 80% | 85.0% of 200 (79.4% … 89.3%) |")
    assert last.endswith("| 5 000 | 1.0 … 2.0 |")
    write_point(tmp_path, "ppo", "Lift", 0, 5000, 0.5, -20.0, 3)
    assert curves(tmp_path) == {("Lift", "ppo"): {0: [(5000.0, 0.5)]}}
