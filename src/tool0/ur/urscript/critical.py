"""The critical section of a program: one thread at a time, in fair turns."""

from __future__ import annotations

import asyncio
from typing import final


@final
class CriticalSection:
    """While a thread is inside, no other thread executes a statement.

    UR does not document how turns are taken.  Here, threads that waited go on before
    the one that leaves can enter again.
    """

    def __init__(self) -> None:
        self._owner: object | None = None
        self._free = asyncio.Event()
        self._is_awaited = False
        """Whether a thread waited since the owner entered."""

    def is_inside(self, thread: object) -> bool:
        """Return whether the thread has entered."""
        return self._owner is thread

    async def wait(self, thread: object) -> None:
        """Wait while another thread is inside."""
        while self._owner is not None and self._owner is not thread:
            self._is_awaited = True
            await self._free.wait()

    async def enter(self, thread: object) -> None:
        """Wait for the turn of the thread; it is inside then."""
        if self._is_awaited and self._owner is None:
            self._is_awaited = False
            await asyncio.sleep(0)  # those that wait are woken up
        await self.wait(thread)
        self._owner = thread
        self._free.clear()

    def leave(self, thread: object) -> None:
        """Let the others go on, if the thread is inside."""
        if self._owner is thread:
            self._owner = None
            self._free.set()
