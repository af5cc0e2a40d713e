"""Episodes of the tasks of ``tool0.gym`` by their experts."""

from __future__ import annotations

import json
from pathlib import Path

import gymnasium
import numpy as np
import pyarrow.parquet as pq
import pytest
from data_sets import content
from raises_naming import raises_naming

from tool0.collect import collect
from tool0.collect.settings import episode_seed
from tool0.errors import CollectError, ConfigError

pytestmark = pytest.mark.slow

N = 6


def test_workers_and_copies_change_no_bit_of_a_lift(tmp_path: Path) -> None:
    options = {"randomise": True}
    one = collect("Lift", N, tmp_path / "a", options=options, workers=1, copies=1)
    two = collect("Lift", N, tmp_path / "b", options=options, workers=2, copies=4)
    assert content(tmp_path / "a") == content(tmp_path / "b")
    assert one.n_succeeded == two.n_succeeded >= N - 1


def test_an_episode_is_that_of_the_environment_with_its_seed(tmp_path: Path) -> None:
    collect("Reach", 3, tmp_path / "reach", workers=1, seed=5)
    row = json.loads((tmp_path / "reach/episodes.jsonl").read_text().splitlines()[2])
    assert row["seed"] == episode_seed(5, 2)
    table = pq.read_table(tmp_path / "reach/data/chunk-000/episode_000002.parquet")
    env = gymnasium.make("tool0/Reach-v0")
    observation, _ = env.reset(seed=row["seed"])
    for frame in table.to_pylist():
        np.testing.assert_array_equal(frame["observation"], observation)
        action = np.array(frame["action"], np.float32)
        observation, reward, terminated, truncated, _ = env.step(action)
        assert (frame["reward"], frame["terminated"], frame["truncated"]) == (
            reward,
            terminated,
            truncated,
        )
    assert terminated or truncated
    env.close()


def test_an_unknown_task_suggests_one(tmp_path: Path) -> None:
    with raises_naming(ConfigError, "unknown task 'Lif'", "did you mean 'Lift'"):
        collect("Lif", 3, tmp_path / "walk")
    with raises_naming(ConfigError, "task 'no_such_module:X-v0'"):
        collect("no_such_module:X-v0", 3, tmp_path / "walk")
    with raises_naming(ConfigError, "task 'CartPol-v1'", "CartPole"):
        collect("CartPol-v1", 3, tmp_path / "walk")
    assert not any(tmp_path.iterdir())


def test_wrong_options_can_be_corrected_in_the_same_folder(tmp_path: Path) -> None:
    folder = tmp_path / "reach"
    with raises_naming(CollectError, "unknown option 'arn'", "did you mean 'arm'"):
        collect("Reach", 1, folder, workers=1, options={"arn": "ur3"})
    assert collect("Reach", 1, folder, workers=1, options={"arm": "ur3"}).is_complete
