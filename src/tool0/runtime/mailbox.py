"""The one way in: requests from any thread, answered by the thread of the tick."""

from __future__ import annotations

import queue
from concurrent.futures import Future
from typing import Any, final

from tool0.runtime.commands import Command

Letter = tuple[Command, "Future[Any]"]  # an answer's type is its command's affair


@final
class Mailbox:
    """A queue of commands, each with a future for its answer."""

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue[Letter] = queue.SimpleQueue()

    def post(self, command: Command) -> Future[Any]:
        """Add ``command``; the future gets its answer, or what went wrong."""
        future: Future[Any] = Future()
        self._queue.put((command, future))
        return future

    def take(self, timeout: float | None = None) -> Letter | None:
        """Return the oldest letter, waiting at most ``timeout`` wall seconds."""
        try:
            if timeout is None:
                return self._queue.get_nowait()
            return self._queue.get(timeout=timeout)
        except queue.Empty:
            return None

    def __bool__(self) -> bool:
        """Return whether there is a letter."""
        return not self._queue.empty()
