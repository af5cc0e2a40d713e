"""Tables of numbers and images as Parquet files."""

from __future__ import annotations

import base64
import io
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Table = Any
"""A ``pyarrow.Table``; pyarrow has no type annotations."""
_NOTE: Final = b"tool0"
"""Key of the note in a file's metadata."""


def is_image(values: Array) -> bool:
    """Return whether values are images: uint8, shape (n_frames, height, width, 3)."""
    return values.dtype == np.uint8 and values.ndim == 4 and values.shape[-1] == 3


def table(
    columns: Mapping[str, Array], metadata: Mapping[bytes, bytes] | None = None
) -> Table:
    """Return a table of columns of shape (n_rows, …); images are stored as PNG."""
    import pyarrow as pa

    arrays = {name: _array(values) for name, values in columns.items()}
    return pa.table(arrays, metadata=metadata)


def file_of(content: Table, note: bytes | None = None) -> bytes:
    """Return a table as a Parquet file; ``note_in`` returns its note."""
    import pyarrow.parquet as pq

    metadata = dict(content.schema.metadata or {})
    metadata.pop(_NOTE, None)  # removes the note of the source file
    content = content.replace_schema_metadata(metadata)
    buffer = io.BytesIO()
    with pq.ParquetWriter(buffer, content.schema, compression="zstd") as writer:
        writer.write_table(content)
        if note is not None:  # other readers require text
            text = base64.b64encode(zlib.compress(note))
            writer.add_key_value_metadata({_NOTE: text})
    return buffer.getvalue()


def note_in(file: Path | io.BytesIO) -> bytes:
    """Return the note of a file that ``file_of`` created, without reading the table."""
    import pyarrow.parquet as pq

    return zlib.decompress(base64.b64decode(pq.read_metadata(file).metadata[_NOTE]))


def nested(values: Array) -> Any:
    """Return rows of shape (n_rows, …) as lists of variable length."""
    import pyarrow as pa

    array = pa.array(values.reshape(-1))
    for k in range(values.ndim - 1, 0, -1):
        length, count = values.shape[k], int(np.prod(values.shape[:k]))
        offsets = np.arange(count + 1, dtype=np.int32) * length
        array = pa.ListArray.from_arrays(pa.array(offsets), array)
    return array


def numbers(column: Any, shape: Sequence[int]) -> Array:
    """Return a column from ``nested`` as an array of shape (n_rows, *shape)."""
    array = column.combine_chunks()
    while hasattr(array, "flatten") and hasattr(array.type, "value_type"):
        array = array.flatten()
    values: Array = array.to_numpy(zero_copy_only=False)
    return values.reshape(-1, *shape)


def _array(values: Array) -> Any:
    import pyarrow as pa

    if is_image(values):
        from tool0.recording.png import encode_png

        pictures = [{"bytes": encode_png(picture), "path": None} for picture in values]
        return pa.array(
            pictures, pa.struct([("bytes", pa.binary()), ("path", pa.string())])
        )
    array = pa.array(values.reshape(-1))
    for length in reversed(values.shape[1:]):
        array = pa.FixedSizeListArray.from_arrays(array, length)
    return array
