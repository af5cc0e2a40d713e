"""Detection of interrupted streams, and the resulting stops of the arms.

A stream consists of two or more target or velocity commands that follow each other
within their timeout.  After a silence that is longer than the timeout, the arm stops.
Later commands, which may have been delayed by a network outage or a suspended sender,
are rejected until the arm has been stopped, or taken again with ``take_arm``.
"""

from __future__ import annotations

import contextlib
import threading
import time
from dataclasses import dataclass
from typing import final

from tool0.errors import ControlError, Tool0Error
from tool0.protocol.arm_motion import EndStream
from tool0.simulation.handlers.table import answer, handles
from tool0.simulation.simulation import Simulation

handles(EndStream, in_tick=True)(
    lambda sim, request: sim.executor.end_stream(request.arm)
)


@dataclass(slots=True)
class _Stream:
    """Commands to one arm since its last stop."""

    last: float
    """Time at which the last command was received, in wall time [s]."""
    timeout: float
    """Duration of silence after which the stream ends, in wall time [s]."""
    is_stream: bool = False
    """Whether at least two commands were received."""
    silence: float | None = None
    """Duration of the silence that ended the stream, in wall time [s]; None while the
    stream has not ended."""


@final
class StreamWatch:
    """Monitors the streams to each arm of a simulation in real time."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._changed = threading.Condition()
        self._streams: dict[str, _Stream] = {}
        self._thread: threading.Thread | None = None
        self._is_closed = False

    def admit(self, arm: str, timeout: float | None, *, is_rest: bool) -> None:
        """Register a command before it is executed.

        Args:
            arm: Name of the arm.
            timeout: Silence after which the stream ends, in wall time [s]; None if the
                stream never ends.
            is_rest: Whether the command brings the arm to rest, which ends a stream in
                the normal way and is always accepted.

        Raises:
            ControlError: If the command continues a stream that has ended.
        """
        now = time.monotonic()
        with self._changed:
            stream = self._streams.get(arm)
            if stream is not None and stream.silence is not None:
                if is_rest:
                    return
                raise ControlError(
                    f"the stream to the arm '{arm}' was silent for "
                    f"{stream.silence:.1f} s and has ended; stop the arm, or take it "
                    "again, before the next one"
                )
            if is_rest or timeout is None:
                self._streams.pop(arm, None)
                return
            if stream is None or now - stream.last > stream.timeout:
                self._streams[arm] = _Stream(now, timeout)
                return
            stream.last, stream.timeout = now, timeout
            if not stream.is_stream:
                stream.is_stream = True
                self._start()
                self._changed.notify()

    def forget(self, arm: str) -> None:
        """Allow a new stream after the arm has been stopped, taken, or given a path."""
        with self._changed:
            self._streams.pop(arm, None)

    def close(self) -> None:
        """Stop the monitoring when the simulation ends."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()
        if self._thread is not None:
            self._thread.join()

    def _start(self) -> None:
        if self._thread is None and not self._is_closed:
            self._thread = threading.Thread(
                target=self._watch, name="tool0 streams", daemon=True
            )
            self._thread.start()

    def _watch(self) -> None:
        while True:
            with self._changed:
                if self._is_closed:
                    return
                silent = self._find_silent()
                if not silent:
                    self._changed.wait(self._remaining())
            for arm in silent:
                with contextlib.suppress(Tool0Error):  # the arm may have been stopped
                    answer(self._simulation, EndStream(arm=arm))

    def _find_silent(self) -> list[str]:
        """Return the arms with streams that end now."""
        now, is_paused = time.monotonic(), self._simulation.snapshot.is_paused
        found = []
        for arm, stream in self._streams.items():
            if not stream.is_stream or stream.silence is not None:
                continue
            if is_paused:
                stream.last = now  # senders may wait for simulated time
            elif now - stream.last > stream.timeout:
                stream.silence = now - stream.last
                found.append(arm)
        return found

    def _remaining(self) -> float | None:
        """Return the wall time until a stream ends [s]; None if no stream is active."""
        now = time.monotonic()
        ends = [
            max(0.0, stream.last + stream.timeout - now) + 1e-3
            for stream in self._streams.values()
            if stream.is_stream and stream.silence is None
        ]
        return min(ends, default=None)
