"""PNG files, read back by FFmpeg."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest
from numpy.typing import NDArray

from tool0.recording.png import encode_depth, encode_png

RANDOM = np.random.default_rng(7)


def read(content: bytes, folder: Path, kind: str) -> NDArray[np.uint16]:
    path = folder / "a.png"
    path.write_bytes(content)
    with av.open(str(path)) as container:
        (frame,) = container.decode(video=0)
        return frame.to_ndarray(format=kind)


@pytest.mark.parametrize("size", [(1, 1), (3, 5), (48, 64)])
def test_colors_come_back(size: tuple[int, int], tmp_path: Path) -> None:
    image = RANDOM.integers(0, 256, (*size, 3), np.uint8)
    assert np.array_equal(read(encode_png(image), tmp_path, "rgb24"), image)


def test_grey_of_16_bits_comes_back(tmp_path: Path) -> None:
    image = RANDOM.integers(0, 65536, (20, 30), np.uint16)
    assert np.array_equal(read(encode_png(image), tmp_path, "gray16le"), image)


def test_depth_is_in_millimetres_and_zero_where_it_is_unknown(tmp_path: Path) -> None:
    depth = np.array([[0.1234, 1.0006, np.inf], [65.0, 70.0, np.nan]], np.float32)
    back = read(encode_depth(depth), tmp_path, "gray16le")
    assert back.tolist() == [[123, 1001, 0], [65000, 0, 0]]


def test_what_is_no_picture_is_refused() -> None:
    with pytest.raises(ValueError, match="float64"):  # its type
        encode_png(np.zeros((2, 2)))  # type: ignore[arg-type]
