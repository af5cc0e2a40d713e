"""Writer of MP4 files, based on PyAV.  Every browser can play the H.264 videos."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from tool0.errors import ConfigError, RenderError
from tool0.user_data import require_writable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_ENCODERS: Final = ("libx264", "libopenh264")
"""H.264 encoders in order of preference; PyAV's wheels include both encoders."""
_OPTIONS: Final = {"libx264": {"crf": "20", "preset": "fast"}}
_BITS_PER_PIXEL: Final = 0.15
"""Number of bits per pixel for the encoder that has no quality option.  This number is
sufficient for smooth surfaces."""


def require_encoder(path: Path | str) -> None:
    """Check that an encoder is available and ``path`` is writable."""
    _encoder()
    require_writable(Path(path))


@final
class VideoWriter:
    """Context manager that writes images as one video.

    After an error, the file is a valid video of the images written so far.
    """

    def __init__(
        self, path: Path | str, width: int, height: int, fps: float = 30.0
    ) -> None:
        """Create the file, or replace an existing file.

        Args:
            path: Path of the MP4 file, which may have any extension.
            width: Width of each image [pixels].  It must be even, because colors are
                encoded at half the resolution.
            height: Height of each image, which must be even [pixels].
            fps: Number of images per second [Hz], 1 … 1000.

        Raises:
            RenderError: If no encoder is available.
            ConfigError: If the file cannot be written, or an argument is out of range.
        """
        if not (width >= 2 and height >= 2 and width % 2 == height % 2 == 0):
            raise ConfigError(
                "width and height of a video must be even, 2 pixels or more, "
                f"got {width} x {height}"
            )
        if not 1.0 <= fps <= 1000.0:
            raise ConfigError(f"fps must be 1 … 1000 images per second, got {fps:g}")
        self._path = Path(path)
        self._shape = (height, width, 3)
        encoder = _encoder()
        require_writable(self._path)
        import av

        self._av: Any = av  # loosely typed
        self._container = av.open(
            str(self._path), "w", format="mp4", options={"movflags": "+faststart"}
        )
        stream: Any = self._container.add_stream(
            encoder, Fraction(fps).limit_denominator(1001)
        )
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        stream.options = _OPTIONS.get(encoder, {})
        if encoder not in _OPTIONS:
            stream.bit_rate = int(_BITS_PER_PIXEL * width * height * fps)
        self._stream: Any = stream

    def write(self, rgb: NDArray[np.uint8]) -> None:
        """Add an image of shape (height, width, 3) with values 0 … 255.

        Raises:
            ConfigError: If the image has a wrong shape or type.
            RenderError: If the image cannot be encoded, or the disk is full.
        """
        if rgb.shape != self._shape or rgb.dtype != "uint8":
            raise ConfigError(
                f"the images of this video have shape {self._shape} and type uint8, "
                f"got {rgb.shape} and {rgb.dtype}"
            )
        self._encode(self._av.VideoFrame.from_ndarray(rgb, format="rgb24"))

    def close(self) -> None:
        """Finish the file; the writer may be closed more than once.

        Raises:
            RenderError: If the end of the video cannot be encoded, or the disk is full.
        """
        if self._stream is None:
            return
        try:
            self._encode(None)
        finally:
            self._stream = None
            with self._translated_errors():
                self._container.close()

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _encode(self, frame: Any) -> None:
        """Encode a frame, or end the stream if ``frame`` is None."""
        if self._stream is None:
            raise RenderError(f"{self._path} is already closed")
        with self._translated_errors():
            self._container.mux(self._stream.encode(frame))

    @contextlib.contextmanager
    def _translated_errors(self) -> Iterator[None]:
        """Raise RenderError instead of FFmpeg's errors."""
        try:
            yield
        except (self._av.error.FFmpegError, OSError) as error:
            raise RenderError(f"{self._path} cannot be written: {error}") from error


def _encoder() -> str:
    try:
        from av.codec import codecs_available
    except ImportError as error:
        raise RenderError(
            f"a video needs PyAV, which cannot be imported ({error}); "
            "run `pip install '.[video]'`"
        ) from error
    for name in _ENCODERS:
        if name in codecs_available:
            return name
    raise RenderError(
        f"this PyAV has no H.264 encoder: {' or '.join(_ENCODERS)}; "
        "run `pip install --force-reinstall av`"
    )
