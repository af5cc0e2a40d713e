"""A queue from many threads to one, which may wait for a limited time.

``queue.SimpleQueue.get`` cannot be used with a timeout: in CPython 3.10 to 3.13 it
waits forever if the timeout expires before it begins to wait, as a short one may, or
any one if the machine stands still.
"""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from typing import Generic, TypeVar, final

T = TypeVar("T")


@final
class Mailbox(Generic[T]):
    """Items in the order in which they were put; only one thread takes them out."""

    def __init__(self) -> None:
        self._items: deque[T] = deque()
        self._arrival = threading.Lock()
        """Released when an item arrives; a thread that waits for one acquires it."""
        self._arrival.acquire()

    def __len__(self) -> int:
        return len(self._items)

    def put(self, item: T) -> None:
        """Add an item; any thread may."""
        self._items.append(item)
        with contextlib.suppress(RuntimeError):  # it was released before
            self._arrival.release()

    def take(self) -> list[T]:
        """Return the next item, if there is one, as a list of one or none."""
        return [self._items.popleft()] if self._items else []

    def wait(self, timeout: float) -> None:
        """Wait until there is an item, at most ``timeout`` [wall s].

        It may return early, without an item, after items were taken without a wait.
        """
        if not self._items:
            self._arrival.acquire(timeout=timeout)
