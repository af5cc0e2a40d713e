"""Encode a picture of the documentation as WebP, which is smaller than PNG.

A WebP file has a fifth of the size of a PNG file.
"""

from __future__ import annotations

import io
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

QUALITY = 85


def encode_webp(rgb: NDArray[np.uint8], reduction: int = 1) -> bytes:
    """Return a picture as WebP data.

    Args:
        rgb: The picture, shape (height, width, 3).
        reduction: Factor by which the picture is reduced, for smooth edges.  After the
            reduction, height and width must be even.
    """
    height, width = (side // reduction for side in rgb.shape[:2])
    file = io.BytesIO()
    with av.open(file, "w", format="webp") as container:
        stream: Any = container.add_stream("libwebp", options={"quality": str(QUALITY)})
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(rgb), format="rgb24")
        small = frame.reformat(width, height, "yuv420p", interpolation="AREA")
        container.mux(stream.encode(small))
        container.mux(stream.encode(None))
    return file.getvalue()
