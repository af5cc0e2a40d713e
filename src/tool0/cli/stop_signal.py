"""A flag for Ctrl-C, SIGTERM and SIGHUP, which the main thread checks between ticks."""

from __future__ import annotations

import select
import signal
import socket
from types import FrameType
from typing import Any, final

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_HANG_UP = getattr(signal, "SIGHUP", None)  # None on Windows


@final
class StopSignal:
    """Catches the first signal; a second signal has its default effect.

    This class does not use ``threading.Event``: a handler that sets an event causes a
    deadlock if it interrupts the main thread while the main thread holds the event's
    lock.
    """

    def __init__(self) -> None:
        self.is_set = False
        self._before: dict[signal.Signals, Any] = {}  # the results of signal.signal

    def __enter__(self) -> StopSignal:
        """Install the handlers."""
        self._read, self._write = socket.socketpair()
        self._write.setblocking(False)
        signals = [*_SIGNALS]
        # With `nohup`, the process ignores SIGHUP; do not change that.
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
        """Return a file descriptor that becomes readable when a signal is received."""
        return self._read.fileno()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait up to ``timeout`` [wall s]; return whether a signal was received."""
        if not self.is_set:
            select.select([self._read], [], [], timeout and max(timeout, 0.0))
        return self.is_set

    def request(self) -> None:
        """Set the flag, as a signal does; any thread can call this method."""
        self.is_set = True
        self._write.send(b"x")

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.request()
        self._restore()

    def _restore(self) -> None:
        for item, handler in self._before.items():
            signal.signal(item, handler)
        self._before = {}
