"""Guards a batch against use by two threads at the same time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import final

from tool0.errors import ControlError


def _nothing() -> None: ...


@final
class OneThread:
    """A re-entrant context that only one thread at a time may enter.

    The context is a class because ``contextlib.contextmanager`` is several times
    slower.
    """

    def __init__(
        self,
        lock: threading.RLock | None = None,
        begin: Callable[[], None] = _nothing,
    ) -> None:
        """Use the given ``lock`` or a new lock; call ``begin`` on entering."""
        self._lock = threading.RLock() if lock is None else lock
        self._begin = begin

    def then(self, begin: Callable[[], None]) -> OneThread:
        """Return a context that shares the lock and calls ``begin`` on entering."""
        return OneThread(self._lock, begin)

    def __enter__(self) -> None:
        """Enter the context; raise ControlError if another thread is in the context."""
        if not self._lock.acquire(blocking=False):
            raise ControlError(
                "another thread is using this batch; give each thread a batch of its "
                "own, or guard this one with a lock"
            )
        try:
            self._begin()
        except BaseException:
            self._lock.release()
            raise

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._lock.release()
