"""The progress of a long command, on standard error."""

from __future__ import annotations

import shutil
import sys
from contextlib import AbstractContextManager
from typing import TextIO, final

_BAR = 24
"""Characters of the bar."""


@final
class ProgressBar(AbstractContextManager["ProgressBar"]):
    """A bar that is drawn over itself on a terminal; else a line for each activity."""

    def __init__(self, stream: TextIO | None = None) -> None:
        """Draw on ``stream``; on standard error if left out."""
        self._stream = sys.stderr if stream is None else stream
        self._is_terminal = self._stream.isatty()
        self._shown = self._activity = ""

    def __exit__(self, *_: object) -> None:
        """Leave the bar's line, so that what follows has its own."""
        self._end_line()

    def __call__(self, activity: str, fraction: float) -> None:
        """Show that ``fraction`` of the activity is done, from 0 to 1."""
        is_new, self._activity = activity != self._activity, activity
        if is_new:
            self._end_line()
        if self._is_terminal:
            self._draw(activity, min(max(fraction, 0.0), 1.0))
        elif is_new:
            print(activity, file=self._stream, flush=True)

    def _draw(self, activity: str, fraction: float) -> None:
        done = int(fraction * _BAR)
        bar = "#" * done + "." * (_BAR - done)
        line = f"{bar} {100 * fraction:3.0f} %  {activity}"
        line = line[: shutil.get_terminal_size().columns - 1]
        if line != self._shown:
            self._stream.write(f"\r\x1b[K{line}")
            self._stream.flush()
            self._shown = line

    def _end_line(self) -> None:
        if self._shown:
            self._stream.write("\n")
            self._stream.flush()
        self._shown = ""
