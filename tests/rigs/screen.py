"""A screen that nobody sees, and what is on it: Xvfb."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

DEPTH = 24
STILL = 0.5
"""How long a screen has to stay the same to be still [wall s]."""


def find_xvfb() -> str | None:
    return shutil.which("Xvfb")


class Screen:
    """An X server of our own; ``environment`` is for programs that draw on it."""

    def __init__(self, width: int, height: int) -> None:
        self._shape = (height, width, 4)
        self._folder = tempfile.TemporaryDirectory(prefix="screen-")
        told, tell = os.pipe()
        self._server = subprocess.Popen(
            [
                find_xvfb() or "Xvfb",
                *("-displayfd", str(tell)),
                *("-screen", "0", f"{width}x{height}x{DEPTH}"),
                *("-fbdir", self._folder.name),
                *("-nolisten", "tcp", "-noreset", "-nocursor"),
            ],
            pass_fds=[tell],
            stderr=subprocess.DEVNULL,
        )
        os.close(tell)
        with open(told) as answer:  # noqa: PTH123  # a number, not a path
            name = f":{answer.readline().strip()}"
        self.environment: Mapping[str, str] = {
            "DISPLAY": name,
            "LIBGL_ALWAYS_SOFTWARE": "1",
        }

    def pixels(self) -> Pixels:
        """Return what is on the screen, shape (height, width, 3), red first."""
        content = Path(self._folder.name, "Xvfb_screen0").read_bytes()
        size = self._shape[0] * self._shape[1] * self._shape[2]
        image = np.frombuffer(content[-size:], np.uint8).reshape(self._shape)
        return image[:, :, 2::-1]

    def wait_for(
        self, is_there: Callable[[Pixels], bool], patience: float
    ) -> Pixels | None:
        """Return the screen once it is so, or None after ``patience`` [wall s]."""
        deadline = time.monotonic() + patience
        while time.monotonic() < deadline:
            pixels = self.pixels()
            if is_there(pixels):
                return pixels
            time.sleep(0.1)  # a screen announces nothing
        return None

    def wait_until_still(self, patience: float) -> Pixels:
        """Return the screen once it has not changed for ``STILL``."""
        last, since = self.pixels(), time.monotonic()

        def is_still(pixels: Pixels) -> bool:
            nonlocal last, since
            if not np.array_equal(pixels, last):
                last, since = pixels, time.monotonic()
            return time.monotonic() - since >= STILL

        pixels = self.wait_for(is_still, patience)
        assert pixels is not None, f"the screen still changes after {patience:g} s"
        return pixels

    def __enter__(self) -> Screen:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._server.terminate()
        self._server.wait()
        self._folder.cleanup()
