"""Encode a picture of the documentation as WebP, a fifth of the size of a PNG."""

from __future__ import annotations

import io
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

QUALITY = 85


def encode_webp(rgb: NDArray[np.uint8]) -> bytes:
    """Return a picture of shape (height, width, 3), even numbers of pixels, as WebP."""
    file = io.BytesIO()
    with av.open(file, "w", format="webp") as container:
        stream: Any = container.add_stream("libwebp", options={"quality": str(QUALITY)})
        stream.height, stream.width = rgb.shape[:2]
        stream.pix_fmt = "yuv420p"
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(rgb), format="rgb24")
        container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return file.getvalue()
