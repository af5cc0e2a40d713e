"""Encoding of images as PNG."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_GREY, _COLORS = 0, 2
"""Color types in the header of a PNG."""


def encode_png(image: NDArray[np.uint8] | NDArray[np.uint16], level: int = 6) -> bytes:
    """Return a PNG of a color image or a gray image.

    A color image is uint8 of shape (height, width, 3).  A gray image is uint16 of shape
    (height, width).  See https://www.w3.org/TR/png-3/ for the format; ``level`` is
    zlib's compression level.

    Raises:
        ValueError: If the image has a wrong shape or type.
    """
    kind = (image.ndim, image.shape[2:], str(image.dtype))
    if kind == (3, (3,), "uint8"):
        depth, color = 8, _COLORS
    elif kind == (2, (), "uint16"):
        depth, color = 16, _GREY
    else:
        raise ValueError(f"no PNG of {image.dtype} in shape {image.shape}")
    height, width = image.shape[:2]
    header = struct.pack(">IIBBBBB", width, height, depth, color, 0, 0, 0)
    chunks = [
        _chunk(b"IHDR", header),
        _chunk(b"IDAT", zlib.compress(_filtered(image), level)),
        _chunk(b"IEND", b""),
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def encode_depth(depth: NDArray[np.float32]) -> bytes:
    """Return depth [m] as a PNG in mm (REP-118).

    A depth that is unknown or above 65.535 m is 0 in the image.
    """
    return encode_png(depth_in_mm(depth))


def depth_in_mm(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Return depth [m] in mm; depths that are unknown or above 65.535 m are 0."""
    import numpy as np

    known = np.isfinite(depth) & (depth < 65.535)
    return np.where(known, np.rint(1000.0 * depth), 0).astype(np.uint16)


def _filtered(image: NDArray[Any]) -> bytes:
    """Return rows as differences from the previous row, which compress better."""
    import numpy as np

    rows = image.astype(image.dtype.newbyteorder(">")).view(np.uint8)
    rows = rows.reshape(image.shape[0], -1)
    up = np.diff(rows, axis=0, prepend=np.zeros_like(rows[:1]))  # modulo 256
    mark = np.full((len(rows), 1), 2, np.uint8)  # the filter "up"
    return np.hstack([mark, up]).tobytes()


def _chunk(kind: bytes, body: bytes) -> bytes:
    check = struct.pack(">I", zlib.crc32(kind + body))
    return struct.pack(">I", len(body)) + kind + body + check
