"""Pictures as PNG (https://www.w3.org/TR/png-3/), which Python itself cannot write."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_GREY, _COLORS = 0, 2


def encode_png(image: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """Return colours (height, width, 3) of 8 bits, or grey (height, width) of 16.

    Raises:
        ValueError: If it is neither.
    """
    kind = (image.ndim, image.shape[2:], str(image.dtype))
    if kind == (3, (3,), "uint8"):
        depth, color = 8, _COLORS
    elif kind == (2, (), "uint16"):
        depth, color = 16, _GREY
    else:
        raise ValueError(f"no PNG of {image.dtype} in shape {image.shape}")
    height, width = image.shape[:2]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        (
            _chunk(
                b"IHDR", struct.pack(">IIBBBBB", width, height, depth, color, 0, 0, 0)
            ),
            _chunk(b"IDAT", zlib.compress(_filtered(image), 6)),
            _chunk(b"IEND", b""),
        )
    )


def encode_depth(depth: NDArray[np.float32]) -> bytes:
    """Return depth [m] as ROS writes it in 16 bits (REP-118): millimetres, 0 unknown.

    What is beyond 65.535 m is unknown, too.
    """
    import numpy as np

    known = np.isfinite(depth) & (depth < 65.535)
    return encode_png(np.where(known, np.rint(1000.0 * depth), 0).astype(np.uint16))


def _filtered(image: NDArray[Any]) -> bytes:
    """Return rows as differences from the row above: smooth pictures shrink so."""
    import numpy as np

    rows = image.astype(image.dtype.newbyteorder(">")).view(np.uint8)
    rows = rows.reshape(image.shape[0], -1)
    up = np.diff(rows, axis=0, prepend=np.zeros_like(rows[:1]))  # modulo 256
    mark = np.full((len(rows), 1), 2, np.uint8)  # the filter "up"
    return np.hstack([mark, up]).tobytes()


def _chunk(kind: bytes, body: bytes) -> bytes:
    check = struct.pack(">I", zlib.crc32(kind + body))
    return struct.pack(">I", len(body)) + kind + body + check
