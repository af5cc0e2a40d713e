"""LeRobot data sets (version 3.0): the files of the episodes and the descriptions.

The format is that of lerobot 0.6.1 (lerobot/datasets/utils.py, feature_utils.py and
dataset_metadata.py, https://github.com/huggingface/lerobot).  Each episode has a
separate file.  The file also contains the features and statistics of the episode, so
the descriptions in the folder ``meta`` can be generated from these files alone.
"""

from __future__ import annotations

import io
import json
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from tool0.collect import parquet
from tool0.collect.parquet import Array, Table, is_image
from tool0.collect.rollout import Episode
from tool0.collect.statistics import NAMES, combined, statistics
from tool0.errors import CollectError, ConfigError

VERSION: Final = "v3.0"
CHUNK: Final = 1000
"""Number of files per folder, and of episodes per file in ``meta/episodes``."""
DATA_PATH: Final = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_EPISODES_PATH: Final = (
    "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
)
_STATE: Final = "observation.state"
_SURROUNDINGS: Final = "observation.environment_state"


def data_path(index: int) -> str:
    """Return the path of an episode's file, relative to the folder."""
    return _numbered(DATA_PATH, index)


def _numbered(pattern: str, number: int) -> str:
    return pattern.format(chunk_index=number // CHUNK, file_index=number % CHUNK)


def whole_rate(rate: float) -> int:
    """Return the frame rate as a whole number [Hz], or raise ConfigError."""
    if not (float(rate).is_integer() and rate > 0.0):
        raise ConfigError(
            f"rate {rate:g} Hz: a LeRobot data set has a whole number of frames per "
            "second, such as 20"
        )
    return int(rate)


# ---- files of episodes ---------------------------------------------------------------


def encoded(episode: Episode, index: int) -> bytes:
    """Return the content of an episode's file, with frames that are numbered from 0.

    Raises:
        ConfigError: If the episode's rate is not a whole number.
    """
    columns, names = _columns(episode)
    n = episode.n_frames
    columns |= {
        "timestamp": (np.arange(n) / episode.rate).astype(np.float32),
        "frame_index": np.arange(n),
        "episode_index": np.full(n, index),
        "index": np.arange(n),
        "task_index": np.zeros(n, np.int64),
    }
    features = {
        name: _feature(values, names.get(name)) for name, values in columns.items()
    }
    description = {
        "fps": whole_rate(episode.rate),
        "features": features,
        "stats": {name: _plain(statistics(values)) for name, values in columns.items()},
    }
    hub = {name: _hub_feature(feature) for name, feature in features.items()}
    metadata = {b"huggingface": json.dumps({"info": {"features": hub}}).encode()}
    table = parquet.table(columns, metadata)
    return parquet.file_of(table, json.dumps(description).encode())


def placed(file: bytes, first_frame: int) -> bytes:
    """Return an episode's file with frames that are numbered from ``first_frame``."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pq.ParquetFile(pa.BufferReader(file)).read(use_threads=False)
    column = table.schema.get_field_index("index")
    numbers = np.arange(first_frame, first_frame + table.num_rows)
    table = table.set_column(column, table.schema.field(column), pa.array(numbers))
    description = json.loads(parquet.note_in(io.BytesIO(file)))
    description["stats"]["index"] = _plain(statistics(numbers))
    return parquet.file_of(table, json.dumps(description).encode())


def observation_columns(
    observations: Mapping[str, Array],
    names: Mapping[str, Sequence[str]],
    surroundings: frozenset[str],
) -> tuple[dict[str, Array], dict[str, list[str]]]:
    """Return the columns of observations, and the names of their components.

    Args:
        observations: Values of n frames, shape (n, …), by name of the observation.
        names: Names of the components by name of the observation, if the components
            have names.
        surroundings: Names of the components that describe the surroundings of the
            robot.

    Raises:
        CollectError: If LeRobot's format has no column for an observation.
    """
    images: dict[str, Array] = {}
    vectors: dict[str, list[tuple[str, Array]]] = {_STATE: [], _SURROUNDINGS: []}
    for key in sorted(observations):
        values = observations[key]
        if is_image(values):
            images[f"observation.images.{key}" if key else "observation.image"] = values
            continue
        if values.ndim > 2:
            raise CollectError(
                f"LeRobot's format has no column for '{key}', of shape "
                f"{values.shape[1:]}: leave it out, or collect in the format parquet"
            )
        flat = values.reshape(len(values), -1)
        for name, column in zip(_names(names, key, flat), flat.T, strict=True):
            place = _SURROUNDINGS if name in surroundings else _STATE
            vectors[place].append((name, column))
    columns = {
        place: np.stack([column for _, column in numbers], axis=1).astype(np.float32)
        for place, numbers in vectors.items()
        if numbers
    }
    found = {place: [name for name, _ in numbers] for place, numbers in vectors.items()}
    return {**columns, **images}, found


def _columns(episode: Episode) -> tuple[dict[str, Array], dict[str, list[str]]]:
    """Return the columns of an episode, and the names of their components."""
    seen, names = observation_columns(
        episode.observations, episode.names, episode.surroundings
    )
    actions = episode.actions.reshape(episode.n_frames, -1)
    ends = np.arange(episode.n_frames) == episode.n_frames - 1
    columns = {
        **{
            name: values if is_image(values) else _narrow(values)
            for name, values in seen.items()
        },
        "action": _narrow(actions),
        "next.reward": episode.rewards.astype(np.float32),
        "next.done": ends,
        "next.success": ends & episode.success,
    }
    return columns, {**names, "action": _names(episode.names, "action", actions)}


def _names(names: Mapping[str, Sequence[str]], key: str, values: Array) -> list[str]:
    """Return the names of the components of an observation or of the action."""
    if key in names:
        return list(names[key])
    name, n = key or "observation", values.shape[1]
    return [name] if n == 1 else [f"{name}.{k}" for k in range(n)]


def _narrow(values: Array) -> Array:
    """Return values in single precision.

    An array of width 1 becomes one-dimensional.
    """
    values = values.astype(np.float32)
    return values[:, 0] if values.shape[1] == 1 else values


def _feature(values: Array, names: list[str] | None) -> dict[str, Any]:
    """Return the description of a column for ``meta/info.json``."""
    if is_image(values):
        names = ["height", "width", "channels"]
        return {"dtype": "image", "shape": list(values.shape[1:]), "names": names}
    shape = list(values.shape[1:]) or [1]
    return {"dtype": str(values.dtype), "shape": shape, "names": names}


def _hub_feature(feature: Mapping[str, Any]) -> dict[str, Any]:
    """Return the description of a column in the format of the library ``datasets``."""
    if feature["dtype"] == "image":
        return {"_type": "Image"}
    value = {"dtype": feature["dtype"], "_type": "Value"}
    if feature["shape"] == [1]:
        return value
    (length,) = feature["shape"]
    return {"feature": value, "length": length, "_type": "Sequence"}


# ---- descriptions of a data set ------------------------------------------------------


def descriptions(
    folder: Path, lengths: Sequence[int], instruction: str
) -> Iterator[tuple[str, bytes]]:
    """Yield the path and the content of each file that must be written to ``meta``.

    Args:
        folder: A data set with at least one episode.
        lengths: Number of frames of each episode.
        instruction: Description of the task, which all episodes share.
    """
    import pyarrow.parquet as pq

    first = _described(folder / data_path(0))
    features = first["features"]
    ends = np.cumsum(lengths)
    parts = []
    for number in range(-(-len(lengths) // CHUNK)):
        indices = range(number * CHUNK, min((number + 1) * CHUNK, len(lengths)))
        place = _numbered(_EPISODES_PATH, number)
        path = folder / place
        if path.exists() and pq.read_metadata(path).num_rows == len(indices):
            rows = pq.ParquetFile(path).read(use_threads=False)
        else:
            rows = _episodes(folder, indices, lengths, ends, instruction)
            yield place, parquet.file_of(rows)
        parts.append(_combined_rows(rows, first["stats"]))
    whole = {
        name: _plain(
            combined({key: np.stack([p[name][key] for p in parts]) for key in NAMES})
        )
        for name in features
    }
    yield "meta/stats.json", _json(whole)
    yield "meta/tasks.parquet", _tasks(instruction)
    info = {
        "codebase_version": VERSION,
        "fps": first["fps"],
        "features": features,
        "total_episodes": len(lengths),
        "total_frames": int(ends[-1]),
        "total_tasks": 1,
        "chunks_size": CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "data_path": DATA_PATH,
        "video_path": None,
        "robot_type": "tool0",
        "splits": {"train": f"0:{len(lengths)}"},
    }
    yield "meta/info.json", _json(info)


def _described(path: Path) -> dict[str, Any]:
    """Return the description that is stored in an episode's file."""
    try:
        found: dict[str, Any] = json.loads(parquet.note_in(path))
    except (OSError, ValueError, LookupError, zlib.error) as error:
        raise CollectError(f"{path} is damaged: {error}") from None
    return found


def _episodes(
    folder: Path,
    indices: range,
    lengths: Sequence[int],
    ends: Array,
    instruction: str,
) -> Table:
    """Return the rows of ``meta/episodes`` for consecutive episodes."""
    import pyarrow as pa

    numbers = np.array(indices)
    length = np.array([lengths[k] for k in indices])
    file = numbers // CHUNK
    columns = {
        "episode_index": numbers,
        "tasks": pa.array([[instruction]] * len(numbers), pa.list_(pa.string())),
        "length": length,
        "data/chunk_index": file,
        "data/file_index": numbers % CHUNK,
        "dataset_from_index": ends[numbers] - length,
        "dataset_to_index": ends[numbers],
    }
    stats = [_described(folder / data_path(index))["stats"] for index in indices]
    for name in stats[0]:
        for key in NAMES:
            values = np.array([each[name][key] for each in stats])
            columns[f"stats/{name}/{key}"] = parquet.nested(values)
    columns["meta/episodes/chunk_index"] = file // CHUNK
    columns["meta/episodes/file_index"] = file % CHUNK
    return pa.table(columns)


def _combined_rows(
    rows: Table, example: Mapping[str, Mapping[str, Any]]
) -> dict[str, dict[str, Array]]:
    """Return the combined statistics of all episodes in ``rows``."""
    return {
        name: combined(
            {
                key: parquet.numbers(rows[f"stats/{name}/{key}"], np.shape(values))
                for key, values in stats.items()
            }
        )
        for name, stats in example.items()
    }


def _tasks(instruction: str) -> bytes:
    """Return the table of tasks; pandas uses the column ``task`` as the index."""
    import pyarrow as pa

    columns = [
        {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy}
        | {"metadata": None}
        for name, kind, numpy in (
            ("task_index", "int64", "int64"),
            ("task", "unicode", "object"),
        )
    ]
    pandas = {"index_columns": ["task"], "column_indexes": [], "columns": columns}
    values = {"task_index": pa.array([0]), "task": pa.array([instruction])}
    metadata = {b"pandas": json.dumps(pandas).encode()}
    return parquet.file_of(pa.table(values, metadata=metadata))


def _plain(stats: Mapping[str, Array]) -> dict[str, Any]:
    return {name: value.tolist() for name, value in stats.items()}


def _json(values: Mapping[str, Any]) -> bytes:
    return f"{json.dumps(values, indent=2)}\n".encode()
