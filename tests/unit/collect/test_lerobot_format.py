"""LeRobot data sets, version 3.0, as lerobot 0.6.1 writes and reads them.

The facts below are those of lerobot/datasets/utils.py (``DatasetInfo`` and the paths),
feature_utils.py, compute_stats.py, dataset_metadata.py and utils/constants.py, and of
the files that its ``LeRobotDataset.create`` makes with pyarrow 26.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from data_sets import content
from fake_tasks import PICTURES, RATE, Homeward
from promised import require_gl
from raises_naming import raises_naming

from tool0.collect import collect, lerobot
from tool0.collect.statistics import combined, statistics
from tool0.errors import CollectError, ConfigError

pytestmark = pytest.mark.slow

N = 12
INFO = {
    "codebase_version": str,
    "fps": int,
    "features": dict,
    "total_episodes": int,
    "total_frames": int,
    "total_tasks": int,
    "chunks_size": int,
    "data_files_size_in_mb": int,
    "video_files_size_in_mb": int,
    "data_path": str,
    "video_path": type(None),
    "robot_type": str,
    "splits": dict,
}
"""Fields of ``DatasetInfo``; others are ignored with a warning."""
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES_PATH = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
FRAME = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
"""``DEFAULT_FEATURES``, each of shape (1,), without names."""
EPISODE = {
    "episode_index": "int64",
    "tasks": "list<element: string>",
    "length": "int64",
    "data/chunk_index": "int64",
    "data/file_index": "int64",
    "dataset_from_index": "int64",
    "dataset_to_index": "int64",
    "meta/episodes/chunk_index": "int64",
    "meta/episodes/file_index": "int64",
}
"""Columns about each episode, beside ``stats/FEATURE/NAME``."""
STATISTICS = ["min", "max", "mean", "std", "count", "q01", "q10", "q50", "q90", "q99"]
NESTED = "list<element: {}>"
COLUMN = {"float32": "float", "bool": "bool", "int64": "int64"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lerobot") / "walk"
    collected(folder, N)
    return folder


def collected(folder: Path, n: int, **options: Any) -> None:
    collect(
        PICTURES,
        n,
        folder,
        workers=1,
        policy=Homeward,
        format="lerobot",
        **{"instruction": "Go home.", **options},
    )


def info_of(folder: Path) -> dict[str, Any]:
    info: dict[str, Any] = json.loads((folder / "meta/info.json").read_text())
    return info


def episodes_of(folder: Path) -> list[dict[str, Any]]:
    path = folder / EPISODES_PATH.format(chunk_index=0, file_index=0)
    rows: list[dict[str, Any]] = pq.ParquetFile(path).read().to_pylist()
    return rows


def test_the_description_has_the_fields_of_the_format(folder: Path) -> None:
    info = info_of(folder)
    assert {name: type(value) for name, value in info.items()} == INFO
    assert info["codebase_version"] == "v3.0"
    assert info["data_path"] == DATA_PATH
    assert (info["fps"], info["chunks_size"]) == (RATE, 1000)
    assert (info["total_episodes"], info["total_tasks"]) == (N, 1)
    assert info["splits"] == {"train": f"0:{N}"}
    meta = {str(path.relative_to(folder)) for path in (folder / "meta").rglob("*.*")}
    assert meta == {
        "meta/info.json",
        "meta/stats.json",
        "meta/tasks.parquet",
        EPISODES_PATH.format(chunk_index=0, file_index=0),
    }


def test_the_tasks_are_a_table_that_pandas_indexes_by_sentence(folder: Path) -> None:
    tasks = pd.read_parquet(folder / "meta/tasks.parquet")
    assert (tasks.index.name, list(tasks.columns)) == ("task", ["task_index"])
    assert tasks.loc["Go home."].task_index == 0
    assert tasks.iloc[0].name == "Go home."


def test_episodes_say_where_their_frames_are(folder: Path) -> None:
    info, episodes = info_of(folder), episodes_of(folder)
    assert len(episodes) == N
    first_frame = 0
    for index, episode in enumerate(episodes):
        assert episode["episode_index"] == index
        assert episode["tasks"] == ["Go home."]
        place = info["data_path"].format(
            chunk_index=episode["data/chunk_index"],
            file_index=episode["data/file_index"],
        )
        table = pq.ParquetFile(folder / place).read()
        n = table.num_rows
        assert n == episode["length"]
        assert episode["dataset_from_index"] == first_frame
        assert episode["dataset_to_index"] == first_frame + n
        assert set(table.column_names) == set(info["features"])
        columns = table.to_pydict()
        assert columns["index"] == list(range(first_frame, first_frame + n))
        assert columns["frame_index"] == list(range(n))
        assert columns["episode_index"] == [index] * n
        assert columns["task_index"] == [0] * n
        # the reader compares them with 1 / fps within 1e-4 s
        np.testing.assert_allclose(np.diff(columns["timestamp"]), 1 / RATE, atol=1e-6)
        assert columns["next.done"] == [False] * (n - 1) + [True]
        first_frame += n
    assert info["total_frames"] == first_frame


def test_files_in_the_order_of_their_names_have_the_frames_in_order(
    folder: Path,
) -> None:
    index = [
        number
        for path in sorted((folder / "data").glob("*/*.parquet"))
        for number in pq.ParquetFile(path).read(["index"])["index"].to_pylist()
    ]
    assert index == list(range(info_of(folder)["total_frames"]))


def test_the_rows_about_episodes_have_the_types_of_the_format(folder: Path) -> None:
    path = folder / EPISODES_PATH.format(chunk_index=0, file_index=0)
    schema = pq.read_schema(path)
    expected = dict(EPISODE)
    for name in info_of(folder)["features"]:
        for key in STATISTICS:
            value = NESTED.format("int64" if key == "count" else "double")
            if name.startswith("observation.images.") and key != "count":
                value = NESTED.format(NESTED.format(value))
            expected[f"stats/{name}/{key}"] = value
    assert {field.name: str(field.type) for field in schema} == expected


def test_features_have_the_types_of_the_columns(folder: Path) -> None:
    features = info_of(folder)["features"]
    table = pq.ParquetFile(folder / "data/chunk-000/file-000.parquet").read()
    hub = json.loads(table.schema.metadata[b"huggingface"])["info"]["features"]
    assert {name: features[name] for name in FRAME} == {
        name: {"dtype": kind, "shape": [1], "names": None}
        for name, kind in FRAME.items()
    }
    assert features["observation.state"] == {
        "dtype": "float32",
        "shape": [3],
        "names": ["position.0", "position.1", "time"],
    }
    assert features["action"]["names"] == ["action.0", "action.1"]
    assert features["observation.images.rgb"] == {
        "dtype": "image",
        "shape": [8, 12, 3],
        "names": ["height", "width", "channels"],
    }
    assert hub["observation.images.rgb"] == {"_type": "Image"}
    for name, feature in features.items():
        kind = table.schema.field(name).type
        if feature["dtype"] == "image":
            assert str(kind) == "struct<bytes: binary, path: string>"
            continue
        column = COLUMN[feature["dtype"]]
        (length,) = feature["shape"]
        if length > 1:
            column = f"fixed_size_list<element: {column}>[{length}]"
        assert str(kind).replace("item", "element") == column
        assert len(feature["names"] or [None] * length) == length


def test_statistics_are_those_of_the_columns(folder: Path) -> None:
    whole: dict[str, list[Any]] = {}
    for index, row in enumerate(episodes_of(folder)):
        table = pq.ParquetFile(folder / f"data/chunk-000/file-{index:03d}.parquet")
        for name, column in table.read().to_pydict().items():
            if name == "observation.images.rgb":
                continue
            whole.setdefault(name, []).extend(column)
            values = np.array(column, np.float64)
            stats = {key: row[f"stats/{name}/{key}"] for key in STATISTICS}
            assert_described(stats, values, rtol=1e-5)
            for key in STATISTICS[5:]:
                expected = np.quantile(values, int(key[1:]) / 100, axis=0)
                np.testing.assert_allclose(stats[key], np.atleast_1d(expected))
        colours = {k: row[f"stats/observation.images.rgb/{k}"] for k in STATISTICS}
        for key in set(STATISTICS) - {"count"}:
            assert np.shape(colours[key]) == (3, 1, 1)
        assert np.max(colours["max"]) <= 1.0
        assert colours["count"] == [row["length"]]
    stats = json.loads((folder / "meta/stats.json").read_text())
    assert stats.keys() == info_of(folder)["features"].keys()
    for name, column in whole.items():
        assert list(stats[name]) == STATISTICS
        assert_described(stats[name], np.array(column, np.float64), rtol=1e-5)
    assert np.shape(stats["observation.images.rgb"]["q50"]) == (3, 1, 1)


def assert_described(stats: Any, values: Any, rtol: float) -> None:
    for key in ("min", "max", "mean", "std"):
        expected = np.atleast_1d(getattr(values, key)(0))
        np.testing.assert_allclose(stats[key], expected, rtol=rtol, atol=1e-6)
    assert stats["count"] == [len(values)]


def test_statistics_of_images_are_those_of_their_pixels() -> None:
    images = np.random.default_rng(0).integers(0, 256, (5, 6, 7, 3), dtype=np.uint8)
    found = statistics(images)
    pixels = images.reshape(-1, 3) / 255.0
    for key in ("min", "max", "mean", "std"):
        expected = getattr(pixels, key)(0)
        np.testing.assert_allclose(found[key][:, 0, 0], expected)
    for key in STATISTICS[5:]:
        share = int(key[1:]) / 100
        expected = np.quantile(pixels, share, axis=0, method="inverted_cdf")
        np.testing.assert_allclose(found[key][:, 0, 0], expected)


def test_parts_combine_to_the_statistics_of_all() -> None:
    rng = np.random.default_rng(1)
    parts = [rng.normal(k, 1.0 + k, (4 + 3 * k, 2)) for k in range(4)]
    each = [statistics(part) for part in parts]
    found = combined({key: np.stack([s[key] for s in each]) for key in STATISTICS})
    whole = np.concatenate(parts)
    assert_described({**found, "count": found["count"].tolist()}, whole, rtol=1e-9)
    weights = [len(part) for part in parts]
    expected = np.average([s["q90"] for s in each], axis=0, weights=weights)
    np.testing.assert_allclose(found["q90"], expected)


def test_a_continued_data_set_is_the_same(folder: Path, tmp_path: Path) -> None:
    for n in (5, N):
        collected(tmp_path / "w", n)
    assert content(tmp_path / "w") == content(folder)


def test_descriptions_of_many_episodes_are_in_several_files(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lerobot, "CHUNK", 5)
    for n in (3, N):
        collected(tmp_path / "w", n)
    files = sorted((tmp_path / "w/meta/episodes").rglob("*.parquet"))
    assert [pq.read_metadata(file).num_rows for file in files] == [5, 5, 2]
    rows = [row for file in files for row in pq.ParquetFile(file).read().to_pylist()]
    places = [(row["data/chunk_index"], row["data/file_index"]) for row in rows]
    assert places == [divmod(k, 5) for k in range(N)]
    assert [row["meta/episodes/file_index"] for row in rows] == [
        k // 5 for k in range(N)
    ]
    one, other = (
        json.loads((each / "meta/stats.json").read_text())
        for each in (folder, tmp_path / "w")
    )
    for name, stats in one.items():
        for key, value in stats.items():
            np.testing.assert_allclose(other[name][key], value, rtol=1e-9, atol=1e-12)


def test_a_sentence_is_part_of_the_data_set(folder: Path, tmp_path: Path) -> None:
    with raises_naming(ConfigError, "instruction", "Go home.", "Stay."):
        collected(folder, N, instruction="Stay.")
    collected(tmp_path / "w", 1, instruction=None)
    assert pd.read_parquet(tmp_path / "w/meta/tasks.parquet").index[0] == PICTURES
    with raises_naming(ConfigError, "instruction", "lerobot"):
        collect(PICTURES, 1, tmp_path / "p", policy=Homeward, instruction="Stay.")


def test_a_rate_that_the_format_does_not_have_is_refused(tmp_path: Path) -> None:
    options = {"control_rate": 12.5}
    with raises_naming(CollectError, "12.5", "whole number"):
        collect("Reach", 1, tmp_path, workers=1, format="lerobot", options=options)


def test_numbers_of_a_task_have_names_and_the_robot_is_apart(tmp_path: Path) -> None:
    options = {"observation": "state", "action": "joint"}
    collect(
        "Push",
        1,
        tmp_path / "p",
        workers=1,
        format="lerobot",
        options=options,
    )
    features = info_of(tmp_path / "p")["features"]
    state = features["observation.state"]["names"]
    around = features["observation.environment_state"]["names"]
    assert state[:2] == ["shoulder_pan_joint.position", "shoulder_lift_joint.position"]
    assert "gripper.opening" in state
    assert "tcp.qw" in state
    assert {"cube.x", "cube.qw", "cube.vx", "tcp_to_cube.x", "goal.x"} <= set(around)
    assert not {name for name in state if "cube" in name or "goal" in name}
    assert features["action"]["names"] == [
        "shoulder_pan_joint",
        "shoulder_lift_joint",
        "elbow_joint",
        "wrist_1_joint",
        "wrist_2_joint",
        "wrist_3_joint",
        "gripper",
    ]
    row = json.loads((tmp_path / "p/episodes.jsonl").read_text().splitlines()[0])
    env = gymnasium.make("tool0/Push-v0", **options)
    observation, _ = env.reset(seed=row["seed"])
    (every,) = env.unwrapped.number_names.observations.values()  # type: ignore[attr-defined]
    env.close()
    file = tmp_path / "p/data/chunk-000/file-000.parquet"
    frame = pq.ParquetFile(file).read().slice(0, 1).to_pylist()[0]
    values = dict(zip(state, frame["observation.state"], strict=True))
    values |= zip(around, frame["observation.environment_state"], strict=True)
    assert values.keys() == set(every)
    np.testing.assert_allclose([values[name] for name in every], observation, atol=1e-6)
    sentence = pd.read_parquet(tmp_path / "p/meta/tasks.parquet").index[0]
    assert sentence == "Push the cube to the goal."


@pytest.mark.parametrize("observation", ["dict", "goal", "image"])
def test_every_observation_has_its_surroundings_apart(
    observation: str, tmp_path: Path
) -> None:
    if observation == "image":
        require_gl()
    collect(
        "Reach",
        1,
        tmp_path / "r",
        workers=1,
        format="lerobot",
        options={"observation": observation},
    )
    features = info_of(tmp_path / "r")["features"]
    around = features["observation.environment_state"]["names"]
    assert {"goal.x", "to_goal.x"} <= set(around)
    assert ("desired_goal.x" in around) == (observation == "goal")
    assert not {
        name for name in features["observation.state"]["names"] if "goal" in name
    }
    assert ("observation.images.rgb" in features) == (observation == "image")


def test_a_damaged_episode_is_told(tmp_path: Path) -> None:
    collected(tmp_path / "w", 2)
    file = tmp_path / "w/data/chunk-000/file-001.parquet"
    file.write_bytes(file.read_bytes()[:-300] + bytes(300))
    with raises_naming(CollectError, "file-001.parquet", "damaged"):
        collected(tmp_path / "w", 3)


def test_a_note_in_a_file_is_read_without_its_table(folder: Path) -> None:
    from tool0.collect import parquet

    file = folder / "data/chunk-000/file-000.parquet"
    note = json.loads(parquet.note_in(file))
    assert note == json.loads(parquet.note_in(io.BytesIO(file.read_bytes())))
    assert note["features"] == info_of(folder)["features"]
