"""Lets the program of a control box follow what others do with the arm."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, final

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox


@final
class ProgramWatch:
    """Pauses the program with its arm, and ends it when it has lost the arm.

    A program of a real UR is paused by a protective stop, and may continue after it.
    Here, it ends: it has to be started anew, from the beginning.
    """

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._task: asyncio.Task[None] | None = None

    async def start(self, host: str, port_base: int) -> None:
        """Watch from now on; there is no port."""
        del host, port_base
        self._box.when_updated.add(self._look)

    async def close(self) -> None:
        """Watch no longer."""
        self._box.when_updated.discard(self._look)
        if self._task is not None:
            await asyncio.wait([self._task])

    def _look(self) -> None:
        box = self._box
        has_lost = box.programs.follow(box.state)
        if box.programs.is_running and box.stopped:
            has_lost = True
        if has_lost and self._task is None:
            if box.stopped:
                box.messages.error(box.stopped)
            self._task = asyncio.create_task(self._stop())

    async def _stop(self) -> None:
        await self._box.programs.stop()
        self._task = None
