"""The critical section of a program: one thread at a time, in a fair order."""

from __future__ import annotations

import asyncio
from typing import final


@final
class CriticalSection:
    """While a thread is inside, no other thread executes a statement.

    A thread leaves the section while it waits for something that takes time.  UR
    documents neither this nor the order of the threads, but its driver's program relies
    on it: the program executes trajectories and reads sockets inside.  Here, ready
    threads run before another thread enters, even if that has just left.
    """

    def __init__(self) -> None:
        self._owner: object | None = None
        self._free = asyncio.Event()

    def is_inside(self, thread: object) -> bool:
        """Return whether the thread is inside."""
        return self._owner is thread

    async def wait(self, thread: object) -> None:
        """Wait while another thread is inside."""
        while self._owner is not None and self._owner is not thread:
            await self._free.wait()

    async def enter(self, thread: object) -> None:
        """Wait for the thread's turn and enter."""
        await asyncio.sleep(0)
        await self.resume(thread)

    async def resume(self, thread: object) -> None:
        """Enter again, at once if no other thread is inside."""
        await self.wait(thread)
        self._owner = thread
        self._free.clear()

    def leave(self, thread: object) -> None:
        """Leave the section, if the thread is inside."""
        if self._owner is thread:
            self._owner = None
            self._free.set()
