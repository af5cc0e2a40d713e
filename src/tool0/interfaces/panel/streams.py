"""Streams of sliders: of a thousand messages only the newest costs anything."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Collection
from dataclasses import dataclass
from typing import Final, final

import msgspec

from tool0.interfaces.panel.protocol import Stream
from tool0.interfaces.panel.source import stream_key

INTERVAL: Final = 0.1
"""Shortest time between two of one stream that are carried out [wall s]."""


@final
@dataclass(frozen=True, slots=True)
class Wish:
    """The newest of a stream, and who sent it."""

    sender: object
    message: Stream


@final
class Streams:
    """Keeps the newest wish of each stream until it is its turn.

    The last one is always carried out, also when its page has gone meanwhile.
    """

    def __init__(self, carry_out: Callable[[Wish], Awaitable[None]]) -> None:
        self._carry_out = carry_out
        self._waiting: dict[str, Wish] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._locks: dict[str, asyncio.Lock] = {}

    def submit(self, wish: Wish) -> None:
        """Put ``wish`` in the place of the one that waits.

        Joints that the same sender wanted elsewhere just before are still wanted there.
        """
        key = stream_key(wish.message)
        before = self._waiting.get(key)
        if before is not None and before.sender is wish.sender:
            positions = {**before.message.positions, **wish.message.positions}
            message = msgspec.structs.replace(wish.message, positions=positions)
            wish = Wish(wish.sender, message)
        self._waiting[key] = wish
        if key not in self._tasks:
            self._tasks[key] = asyncio.create_task(self._run(key))

    def drop(self, keys: Collection[str]) -> None:
        """Forget what waits: something newer was asked for."""
        for key in keys:
            self._waiting.pop(key, None)

    async def settle(self, keys: Collection[str]) -> None:
        """Forget what waits, and wait for what is being carried out."""
        self.drop(keys)
        for key in keys:
            if key in self._locks:
                async with self._locks[key]:
                    pass

    def close(self) -> None:
        """Forget everything."""
        self._waiting.clear()
        for task in self._tasks.values():
            task.cancel()

    async def _run(self, key: str) -> None:
        lock = self._locks.setdefault(key, asyncio.Lock())
        loop = asyncio.get_running_loop()
        try:
            while key in self._waiting:
                start = loop.time()
                async with lock:
                    wish = self._waiting.pop(key, None)  # settled meanwhile
                    if wish is not None:
                        await self._carry_out(wish)
                await asyncio.sleep(start + INTERVAL - loop.time())
        finally:
            del self._tasks[key]
