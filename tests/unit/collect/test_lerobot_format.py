"""LeRobot data sets, version 2.1, as their readers expect them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from data_sets import content
from fake_tasks import PICTURES, RATE, Homeward

from tool0.collect import collect

pytestmark = pytest.mark.slow

N = 12
FRAME = {"timestamp", "frame_index", "episode_index", "index", "task_index"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lerobot") / "walk"
    collect(PICTURES, N, folder, workers=1, policy=Homeward, format="lerobot")
    return folder


def lines(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_the_description_agrees_with_the_files(folder: Path) -> None:
    info = json.loads((folder / "meta/info.json").read_text())
    assert info["codebase_version"] == "v2.1"
    assert info["fps"] == RATE
    assert info["total_episodes"] == N
    assert info["splits"] == {"train": f"0:{N}"}
    assert lines(folder / "meta/tasks.jsonl") == [{"task_index": 0, "task": PICTURES}]
    episodes = lines(folder / "meta/episodes.jsonl")
    first_frame = 0
    for index, episode in enumerate(episodes):
        assert episode["episode_index"] == index
        assert episode["tasks"] == [PICTURES]
        place = info["data_path"].format(episode_chunk=0, episode_index=index)
        table = pq.read_table(folder / place)
        n = table.num_rows
        assert n == episode["length"]
        assert set(table.column_names) == set(info["features"])
        assert set(info["features"]) > FRAME
        columns = table.to_pydict()
        assert columns["index"] == list(range(first_frame, first_frame + n))
        assert columns["frame_index"] == list(range(n))
        assert columns["episode_index"] == [index] * n
        np.testing.assert_allclose(np.diff(columns["timestamp"]), 1 / RATE, atol=1e-6)
        assert columns["next.done"] == [False] * (n - 1) + [True]
        first_frame += n
    assert info["total_frames"] == first_frame


def test_features_have_the_types_of_the_columns(folder: Path) -> None:
    features = json.loads((folder / "meta/info.json").read_text())["features"]
    table = pq.read_table(folder / "data/chunk-000/episode_000000.parquet")
    hub = json.loads(table.schema.metadata[b"huggingface"])["info"]["features"]
    assert features["observation.state"]["shape"] == [3]  # position and time
    assert features["observation.images.rgb"]["dtype"] == "image"
    assert hub["observation.images.rgb"] == {"_type": "Image"}
    for name, feature in features.items():
        if feature["dtype"] == "image":
            continue
        values = np.array(table[name].to_pylist())
        assert list(values.shape[1:]) == (
            [] if feature["shape"] == [1] else feature["shape"]
        )
        kind = str(table.schema.field(name).type)
        assert {"float32": "float", "bool": "bool", "int64": "int64"}[
            feature["dtype"]
        ] in kind


def test_statistics_are_those_of_the_columns(folder: Path) -> None:
    for row in lines(folder / "meta/episodes_stats.jsonl"):
        index, stats = row["episode_index"], row["stats"]
        table = pq.read_table(folder / f"data/chunk-000/episode_{index:06d}.parquet")
        assert set(stats) == set(table.column_names)
        for name in set(stats) - {"observation.images.rgb"}:
            values = np.array(table[name].to_pylist())
            for key in ("min", "max", "mean", "std"):
                expected = np.atleast_1d(getattr(values, key)(0))
                np.testing.assert_allclose(
                    stats[name][key], expected, rtol=1e-5, atol=1e-6
                )
            assert stats[name]["count"] == [len(values)]
        assert np.shape(stats["observation.images.rgb"]["mean"]) == (3, 1, 1)
        assert np.max(stats["observation.images.rgb"]["max"]) <= 1.0


def test_a_continued_data_set_is_the_same(folder: Path, tmp_path: Path) -> None:
    for n in (5, N):
        collect(
            PICTURES, n, tmp_path / "w", workers=1, policy=Homeward, format="lerobot"
        )
    assert content(tmp_path / "w") == content(folder)


def test_rows_that_only_one_file_has_are_collected_again(
    folder: Path, tmp_path: Path
) -> None:
    collect(PICTURES, 5, tmp_path / "w", workers=1, policy=Homeward, format="lerobot")
    stats = tmp_path / "w/meta/episodes_stats.jsonl"
    stats.write_text("".join(stats.read_text().splitlines(keepends=True)[:3]))
    collect(PICTURES, N, tmp_path / "w", workers=1, policy=Homeward, format="lerobot")
    assert content(tmp_path / "w") == content(folder)
