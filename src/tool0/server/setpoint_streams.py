"""Streams of setpoints from connections."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Collection
from dataclasses import dataclass
from typing import Any, Final, final

import msgspec

INTERVAL: Final = 0.1
"""Shortest time between two setpoints of a stream that are executed [wall s]."""


@final
@dataclass(frozen=True, slots=True)
class StreamedSetpoint:
    """The newest setpoint of a stream, with its sender."""

    sender: object
    request: Any
    """Request with ``positions``."""


@final
class SetpointStreams:
    """Buffer of the newest setpoint of each stream until it is due.

    If many setpoints are received, only the newest setpoint is executed.  The last
    setpoint is always executed, even if its sender has disconnected.
    """

    def __init__(
        self, carry_out: Callable[[StreamedSetpoint], Awaitable[None]]
    ) -> None:
        self._carry_out = carry_out
        self._waiting: dict[str, StreamedSetpoint] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._locks: dict[str, asyncio.Lock] = {}

    def submit(self, setpoint: StreamedSetpoint) -> None:
        """Replace the waiting setpoint with ``setpoint``.

        Joints that are only in an older setpoint from the same sender keep their
        positions from that setpoint.
        """
        key = getattr(setpoint.request, "controller", "")
        before = self._waiting.get(key)
        if before is not None and before.sender is setpoint.sender:
            positions = {**before.request.positions, **setpoint.request.positions}
            request = msgspec.structs.replace(setpoint.request, positions=positions)
            setpoint = StreamedSetpoint(setpoint.sender, request)
        self._waiting[key] = setpoint
        if key not in self._tasks:
            self._tasks[key] = asyncio.create_task(self._run(key))

    def drop(self, keys: Collection[str]) -> None:
        """Drop the waiting setpoints of streams that a newer request supersedes."""
        for key in keys:
            self._waiting.pop(key, None)

    async def settle(self, keys: Collection[str]) -> None:
        """Drop waiting setpoints, and wait for setpoints that are being executed."""
        self.drop(keys)
        for key in keys:
            if key in self._locks:
                async with self._locks[key]:
                    pass

    def drop_all(self) -> None:
        """Drop every waiting setpoint."""
        self._waiting.clear()

    def close(self) -> None:
        """Drop all setpoints and streams."""
        self.drop_all()
        for task in self._tasks.values():
            task.cancel()

    async def _run(self, key: str) -> None:
        lock = self._locks.setdefault(key, asyncio.Lock())
        loop = asyncio.get_running_loop()
        try:
            while key in self._waiting:
                start = loop.time()
                async with lock:
                    setpoint = self._waiting.pop(key, None)  # may have been dropped
                    if setpoint is not None:
                        await self._carry_out(setpoint)
                await asyncio.sleep(start + INTERVAL - loop.time())
        finally:
            del self._tasks[key]
