"""A queue from several threads to one thread, which can wait with a timeout.

``queue.SimpleQueue.get`` cannot be used with a timeout: in CPython 3.10 to 3.13, it
waits forever if the timeout expires before the wait begins.  The timeout can expire
this early if it is short, or if the process is suspended.
"""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from typing import Generic, TypeVar, final

T = TypeVar("T")


@final
class Mailbox(Generic[T]):
    """Items in the order in which they were added.

    Only one thread may take items.
    """

    def __init__(self) -> None:
        self._items: deque[T] = deque()
        self._arrival = threading.Lock()
        """Lock that is released when an item is added.  A thread that waits for an item
        acquires the lock."""
        self._arrival.acquire()

    def __len__(self) -> int:
        return len(self._items)

    def put(self, item: T) -> None:
        """Add an item.

        Any thread may call ``put``.
        """
        self._items.append(item)
        with contextlib.suppress(RuntimeError):  # already released
            self._arrival.release()

    def take(self) -> list[T]:
        """Return a list with the next item, or an empty list if there is none."""
        return [self._items.popleft()] if self._items else []

    def wait(self, timeout: float) -> None:
        """Wait until there is an item, for at most ``timeout`` of wall time [s].

        The function may return early, without an item, after items were taken without a
        wait.
        """
        if not self._items:
            self._arrival.acquire(timeout=timeout)
