"""Synchronization of a control box's program with the state of the arm."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final, final

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

PROTECTIVE_STOP: Final = 209
"""UR's error C209: a protective stop was triggered."""
PATH_DEVIATION: Final = 153
"""UR's error C153: the arm has deviated from its path."""


@final
class ProgramWatch:
    """Pauses the program with the arm; ends it if it loses control of the arm.

    The watch also reports to the clients why the arm stopped, even if no program is
    running. On a real UR, a protective stop pauses the program, which may continue
    afterwards. In tool0, a protective stop ends the program, which must be restarted
    from the beginning.
    """

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._task: asyncio.Task[None] | None = None
        self._seen = ""
        """Reason for the stop at the last update."""
        self._told = ""
        """Reason that was reported last."""

    async def start(self, host: str, port_base: int) -> None:
        """Start to monitor the arm; no port is opened."""
        del host, port_base
        self._box.when_updated.add(self._look)

    async def close(self) -> None:
        """Stop monitoring the arm."""
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
            if box.stopped and not self._reason:
                box.messages.error(box.stopped)
            self._task = asyncio.create_task(self._stop())

    @property
    def _reason(self) -> str:
        """Reason for a stop without a command; empty if there was no such stop."""
        return self._box.state.protective_stop or self._box.state.motion_failure

    def _tell(self) -> None:
        """Report once why the arm has stopped.

        The report is sent at the second update with the same reason, so that clients
        receive the safety mode first.
        """
        box, reason = self._box, self._reason
        if reason == self._seen and reason != self._told:
            self._told = reason
            if box.state.protective_stop:
                box.messages.error(box.stopped, PROTECTIVE_STOP, is_warning=True)
            elif reason:
                box.messages.error(box.stopped, PATH_DEVIATION)
        self._seen = reason

    async def _stop(self) -> None:
        await self._box.programs.stop()
        self._task = None
