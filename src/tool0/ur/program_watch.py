"""Lets the program of a control box follow what others do with the arm."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final, final

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

PROTECTIVE_STOP: Final = 209
"""UR's error C209: a protective stop was triggered."""
PATH_DEVIATION: Final = 153
"""UR's error C153: the position deviates from the path."""


@final
class ProgramWatch:
    """Pauses the program with its arm, and ends it when it has lost the arm.

    Clients are told why the arm stopped, with a program or without.

    A program of a real UR is paused by a protective stop, and may continue after it.
    Here, it ends: it has to be started anew, from the beginning.
    """

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._task: asyncio.Task[None] | None = None
        self._told = ""
        """Why the arm had stopped when clients were told last."""

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
        self._tell()
        if has_lost and self._task is None:
            self._task = asyncio.create_task(self._stop())

    def _tell(self) -> None:
        """Tell clients why the arm has stopped, once."""
        box, state = self._box, self._box.state
        why = state.protective_stop or state.motion_failure
        if not why and box.programs.is_running:
            why = box.stopped
        if why and why != self._told:
            code = 0
            if state.protective_stop:
                code = PROTECTIVE_STOP
            elif state.motion_failure:
                code = PATH_DEVIATION
            is_warning = code == PROTECTIVE_STOP  # the arm can be unlocked
            box.messages.error(box.stopped, code, is_warning=is_warning)
        self._told = why

    async def _stop(self) -> None:
        await self._box.programs.stop()
        self._task = None
