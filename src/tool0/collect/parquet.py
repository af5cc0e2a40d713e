"""Episodes as Parquet files, with the columns of the formats ``parquet`` and LeRobot.

LeRobot's is version 2.1 of its data sets:
https://github.com/huggingface/lerobot (lerobot/common/datasets/utils.py of May 2025).
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from tool0.collect.rollout import Array, Episode
from tool0.collect.settings import Format

Table = Any
"""A ``pyarrow.Table``; pyarrow has no types."""

_DESCRIPTION: Final = b"tool0"
"""Key of the file's metadata with rate and columns of a LeRobot data set."""


def encoded(episode: Episode, index: int, form: Format) -> tuple[dict[str, Any], bytes]:
    """Return an episode's row of the manifest, and its file.

    A file of a LeRobot data set counts its frames from 0, see ``placed``.
    """
    is_lerobot = form == "lerobot"
    frames = _lerobot(episode) if is_lerobot else _columns(episode)
    row: dict[str, Any] = {
        "episode_index": index,
        "seed": episode.seed,
        "length": episode.n_frames,
        "success": episode.success,
        "terminated": episode.terminated,
        "return": float(episode.rewards.sum()),
    }
    n = episode.n_frames
    frames |= {
        "timestamp": (np.arange(n) / episode.rate).astype(np.float32),
        "frame_index": np.arange(n),
        "episode_index": np.full(n, index),
    }
    metadata = {}
    if is_lerobot:
        frames |= {"index": np.arange(n), "task_index": np.zeros(n, np.int64)}
        row["stats"] = {name: _statistics(values) for name, values in frames.items()}
        metadata = _metadata(frames, _number_names(episode), episode.rate)
    return row, _file(_table(frames, metadata))


def placed(
    row: Mapping[str, Any], file: bytes, first_frame: int
) -> tuple[dict[str, Any], bytes]:
    """Return the row and the file of a LeRobot episode after ``first_frame`` others."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pq.ParquetFile(pa.BufferReader(file)).read(use_threads=False)
    column = table.schema.get_field_index("index")
    numbers = np.arange(first_frame, first_frame + table.num_rows)
    table = table.set_column(column, table.schema.field(column), pa.array(numbers))
    stats = {**row["stats"], "index": _statistics(numbers)}
    return {**row, "stats": stats}, _file(table)


def description(file: bytes) -> dict[str, Any]:
    """Return ``fps`` and ``features`` of a LeRobot data set, from one of its files."""
    import pyarrow.parquet as pq

    metadata = pq.read_schema(io.BytesIO(file)).metadata
    found: dict[str, Any] = json.loads(metadata[_DESCRIPTION])
    return found


# ---- columns -------------------------------------------------------------------------


def _columns(episode: Episode) -> dict[str, Array]:
    ends = np.arange(episode.n_frames) == episode.n_frames - 1
    return {
        **{
            f"observation.{name}" if name else "observation": values
            for name, values in episode.observations.items()
        },
        "action": episode.actions,
        "reward": episode.rewards,
        "terminated": ends & episode.terminated,
        "truncated": ends & (not episode.terminated),
        "success": ends & episode.success,
    }


def _lerobot(episode: Episode) -> dict[str, Array]:
    names = sorted(episode.observations)
    images = [name for name in names if _is_image(episode.observations[name])]
    state = [_numbers(episode, name) for name in names if name not in images]
    ends = np.arange(episode.n_frames) == episode.n_frames - 1
    return {
        "observation.state": _narrow(np.hstack(state)),
        **{f"observation.images.{name}": episode.observations[name] for name in images},
        "action": _narrow(episode.actions),
        "next.reward": episode.rewards.astype(np.float32),
        "next.done": ends,
        "next.success": ends & episode.success,
    }


def _numbers(episode: Episode, name: str) -> Array:
    """Return an observation, shape (n_frames, n)."""
    return episode.observations[name].reshape(episode.n_frames, -1)


def _number_names(episode: Episode) -> dict[str, list[str]]:
    """Return column → names of its numbers; nothing for an episode without names."""
    if not episode.names:
        return {}
    state: list[str] = []
    for name in sorted(episode.observations):
        if not _is_image(episode.observations[name]):
            numbers = range(_numbers(episode, name).shape[1])
            state += episode.names.get(name, [f"{name}.{k}" for k in numbers])
    return {"observation.state": state, "action": list(episode.names["action"])}


def _narrow(values: Array) -> Array:
    """Return 32-bit numbers; a column of single ones is no column of lists."""
    values = values.astype(np.float32)
    return values[:, 0] if values.shape[1] == 1 else values


def _is_image(values: Array) -> bool:
    """Whether an observation is colours, shape (n_frames, height, width, 3)."""
    return values.dtype == np.uint8 and values.ndim == 4 and values.shape[-1] == 3


def _statistics(values: Array) -> dict[str, list[Any]]:
    """Return what LeRobot normalises by: of each number, or of each colour in 0 … 1."""
    if _is_image(values):
        return _image_statistics(values)
    found = {
        "min": values.min(0),
        "max": values.max(0),
        "mean": values.mean(0),
        "std": values.std(0),
    }
    return {
        **{name: np.atleast_1d(value).tolist() for name, value in found.items()},
        "count": [len(values)],
    }


def _image_statistics(images: Array) -> dict[str, list[Any]]:
    """Return the same of each colour, from how often each of its 256 values occurs."""
    levels = np.arange(256) / 255.0
    counts = np.zeros((3, 256), np.int64)
    for image in images:
        for channel in range(3):
            counts[channel] += np.bincount(image[..., channel].ravel(), minlength=256)
    mean = counts @ levels / counts.sum(axis=1)
    spread = np.square(levels - mean[:, None])
    found = {
        "min": [levels[row.nonzero()[0][0]] for row in counts],
        "max": [levels[row.nonzero()[0][-1]] for row in counts],
        "mean": mean,
        "std": np.sqrt((counts * spread).sum(axis=1) / counts.sum(axis=1)),
    }
    return {
        **{name: [[[float(v)]] for v in value] for name, value in found.items()},
        "count": [len(images)],
    }


# ---- files ---------------------------------------------------------------------------


def _metadata(
    frames: Mapping[str, Array], names: Mapping[str, list[str]], rate: float
) -> dict[bytes, bytes]:
    """Return the metadata of a file of a LeRobot data set."""
    found = {name: _feature(values, names.get(name)) for name, values in frames.items()}
    hub = {name: _hub_feature(feature) for name, feature in found.items()}
    fps = int(rate) if rate.is_integer() else rate
    return {
        _DESCRIPTION: json.dumps({"fps": fps, "features": found}).encode(),
        b"huggingface": json.dumps({"info": {"features": hub}}).encode(),
    }


def _table(frames: Mapping[str, Array], metadata: Mapping[bytes, bytes]) -> Table:
    import pyarrow as pa

    arrays = {name: _array(values) for name, values in frames.items()}
    return pa.table(arrays, metadata=metadata)


def _array(values: Array) -> Any:
    import pyarrow as pa

    if _is_image(values):
        from tool0.recording.png import encode_png

        pictures = [{"bytes": encode_png(picture), "path": None} for picture in values]
        return pa.array(
            pictures, pa.struct([("bytes", pa.binary()), ("path", pa.string())])
        )
    array = pa.array(values.reshape(-1))
    for length in reversed(values.shape[1:]):
        array = pa.FixedSizeListArray.from_arrays(array, length)
    return array


def _file(table: Table) -> bytes:
    import pyarrow.parquet as pq

    buffer = io.BytesIO()
    pq.write_table(table, buffer, compression="zstd")
    file: bytes = buffer.getvalue()
    return file


def _feature(values: Array, names: list[str] | None) -> dict[str, Any]:
    """Return the description of a column as ``meta/info.json`` has it.

    Numbers without ``names`` are counted from 0.
    """
    if _is_image(values):
        names = ["height", "width", "channel"]
        return {"dtype": "image", "shape": list(values.shape[1:]), "names": names}
    shape = list(values.shape[1:]) or [1]
    if names is None and values.ndim == 2:
        names = [str(k) for k in range(shape[0])]
    return {"dtype": str(values.dtype), "shape": shape, "names": names}


def _hub_feature(feature: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same as the library ``datasets`` reads it."""
    if feature["dtype"] == "image":
        return {"_type": "Image"}
    value = {"dtype": feature["dtype"], "_type": "Value"}
    if feature["shape"] == [1]:
        return value
    (length,) = feature["shape"]
    return {"feature": value, "length": length, "_type": "Sequence"}
