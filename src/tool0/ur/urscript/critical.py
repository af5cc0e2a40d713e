"""The critical section of a program, which threads enter one at a time."""

from __future__ import annotations

import asyncio
from typing import final


@final
class CriticalSection:
    """While a thread is in the section, no other thread executes a statement.

    A thread leaves the section while it waits for an action that takes time. UR does
    not document when a thread leaves the section or in which order threads enter it.
    The program of UR's driver executes trajectories and reads sockets inside the
    section, so the driver depends on threads leaving the section while they wait. In
    tool0, ready threads run before another thread enters the section, even if that
    thread has just left it.
    """

    def __init__(self) -> None:
        self._owner: object | None = None
        self._free = asyncio.Event()

    def is_inside(self, thread: object) -> bool:
        """Return whether the thread is in the section."""
        return self._owner is thread

    async def wait(self, thread: object) -> None:
        """Wait while another thread is in the section."""
        while self._owner is not None and self._owner is not thread:
            await self._free.wait()

    async def enter(self, thread: object) -> None:
        """Wait for the thread's turn and enter the section."""
        await asyncio.sleep(0)
        await self.resume(thread)

    async def resume(self, thread: object) -> None:
        """Enter the section again; this is immediate if no other thread is in it."""
        await self.wait(thread)
        self._owner = thread
        self._free.clear()

    def leave(self, thread: object) -> None:
        """Leave the section if the thread is in it."""
        if self._owner is thread:
            self._owner = None
            self._free.set()
