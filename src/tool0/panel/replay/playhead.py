"""The playback position in a recording, with play, pause, loop and seek functions."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import final

MIN_SPEED, MAX_SPEED = 0.01, 100.0


@final
class Playhead:
    """A time that advances with the wall clock between a start and an end.

    This class is thread-safe.
    """

    def __init__(
        self, start: float, end: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Start paused at ``start`` [s]; ``clock`` returns wall time [s]."""
        self._start, self._end = start, end
        self._clock = clock
        self._lock = threading.Lock()
        self._time = start
        self._since = clock()
        self._is_playing = False
        self._speed = 1.0
        self._loops = False

    @property
    def time(self) -> float:
        """The displayed simulated time [s]."""
        with self._lock:
            return self._update()

    @property
    def is_playing(self) -> bool:
        """Whether the playback is running; it stops at the end unless it loops."""
        with self._lock:
            self._update()
            return self._is_playing

    @property
    def speed(self) -> float:
        """Recorded seconds per wall second."""
        return self._speed

    @property
    def loops(self) -> bool:
        """Whether playback continues from the start after the end."""
        return self._loops

    def play(self) -> None:
        """Start the playback, from the beginning if it has reached the end."""
        with self._lock:
            if self._update() >= self._end:
                self._time = self._start
            self._is_playing = True

    def pause(self) -> None:
        """Pause the playback."""
        with self._lock:
            self._update()
            self._is_playing = False

    def seek(self, time: float) -> None:
        """Set the displayed time [s], clamped to the range of the recording."""
        with self._lock:
            self._update()
            self._time = min(self._end, max(self._start, time))

    def set_speed(self, speed: float) -> None:
        """Set the speed of the playback, clamped to the allowed range."""
        with self._lock:
            self._update()
            self._speed = min(MAX_SPEED, max(MIN_SPEED, speed))

    def set_loops(self, loops: bool) -> None:
        """Set whether playback loops or stops at the end."""
        with self._lock:
            self._update()
            self._loops = loops

    def _update(self) -> float:
        """Advance by the wall time since the last call, and return the new time."""
        now = self._clock()
        passed, self._since = now - self._since, now
        if self._is_playing:
            self._time += passed * self._speed
            if self._time >= self._end:
                span = self._end - self._start
                if self._loops and span > 0.0:
                    self._time = self._start + (self._time - self._start) % span
                else:
                    self._time, self._is_playing = self._end, False
        return self._time
