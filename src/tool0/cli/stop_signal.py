"""Ctrl-C, SIGTERM and SIGHUP as a flag that the main thread checks between ticks."""

from __future__ import annotations

import select
import signal
import socket
from types import FrameType
from typing import Any, final

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_HANG_UP = getattr(signal, "SIGHUP", None)  # not on Windows


@final
class StopSignal:
    """Catches the first signal; a second one ends the process as usual.

    Not a ``threading.Event``: a handler that sets one deadlocks if it interrupts the
    main thread inside the event's own lock.
    """

    def __init__(self) -> None:
        self.is_set = False
        self._before: dict[signal.Signals, Any] = {}  # what signal.signal returns

    def __enter__(self) -> StopSignal:
        """Install the handlers."""
        self._read, self._write = socket.socketpair()
        self._write.setblocking(False)
        signals = [*_SIGNALS]
        # `nohup` lets a process ignore that its terminal is closed.
        if _HANG_UP is not None and signal.getsignal(_HANG_UP) != signal.SIG_IGN:
            signals.append(_HANG_UP)
        self._before = {item: signal.signal(item, self._note) for item in signals}
        return self

    def __exit__(self, *_: object) -> None:
        """Restore the handlers."""
        self._restore()
        self._read.close()
        self._write.close()

    def fileno(self) -> int:
        """Return a file descriptor that becomes readable when a signal arrives."""
        return self._read.fileno()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait up to ``timeout`` [wall s] for a signal; return whether one arrived."""
        if not self.is_set:
            select.select([self._read], [], [], timeout and max(timeout, 0.0))
        return self.is_set

    def request(self) -> None:
        """Act as if a signal had arrived; this can be called from any thread."""
        self.is_set = True
        self._write.send(b"x")

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.request()
        self._restore()

    def _restore(self) -> None:
        for item, handler in self._before.items():
            signal.signal(item, handler)
        self._before = {}
