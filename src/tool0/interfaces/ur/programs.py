"""The program of a control box: one at a time has the arm."""

from __future__ import annotations

import asyncio
import logging
from enum import IntEnum
from typing import TYPE_CHECKING, Protocol, final

from tool0.errors import ControlError, Tool0Error
from tool0.requests.arm_motion import ReturnArm, TakeArm

if TYPE_CHECKING:
    from tool0.interfaces.ur.box import Box

logger = logging.getLogger(__name__)


class RuntimeState(IntEnum):
    """What the program does, by the numbers of RTDE."""

    STOPPING = 0
    STOPPED = 1
    PLAYING = 2
    PAUSING = 3
    PAUSED = 4
    RESUMING = 5


class Program(Protocol):
    """A program that can run."""

    @property
    def name(self) -> str: ...

    async def run(self, box: Box) -> None:
        """Run to the end; it is cancelled to be stopped.

        Raises:
            Tool0Error: If the program fails, with the reason.
        """


@final
class ProgramSlot:
    """Starts, pauses and stops the program of one control box."""

    def __init__(self, box: Box) -> None:
        self._box = box
        self._task: asyncio.Task[None] | None = None
        self._gate = asyncio.Event()
        self._gate.set()
        self.state = RuntimeState.STOPPED
        self.name = ""
        """Of the program that runs, or ran last."""

    @property
    def is_running(self) -> bool:
        """Whether there is a program, running or paused."""
        return self._task is not None

    @property
    def is_paused(self) -> bool:
        """Whether a program waits to be resumed."""
        return self.state is RuntimeState.PAUSED

    async def start(self, program: Program) -> None:
        """Stop the program that runs, and start another one.

        Raises:
            ControlError: If the arm may not move now.
        """
        await self.stop()
        await self._box.call(TakeArm(arm=self._box.arm, by=program.name))
        self.name = program.name
        self.state = RuntimeState.PLAYING
        self._task = asyncio.create_task(self._run(program))
        self._box.messages.program(program.name)

    async def stop(self) -> None:
        """Stop the program and the arm; without a program, do nothing."""
        task = self._task
        if task is None or task is asyncio.current_task():
            return
        self.state = RuntimeState.STOPPING
        task.cancel()
        await asyncio.wait([task])

    def pause(self) -> None:
        """Hold the program at its next statement, and its motion.

        Raises:
            ControlError: If none is running.
        """
        if self.state is not RuntimeState.PLAYING:
            raise ControlError("no program is running")
        self._gate.clear()
        self.state = RuntimeState.PAUSED

    def resume(self) -> None:
        """Continue a paused program.

        Raises:
            ControlError: If none is paused.
        """
        if self.state is not RuntimeState.PAUSED:
            raise ControlError("no program is paused")
        self._gate.set()
        self.state = RuntimeState.PLAYING

    async def gate(self) -> None:
        """Return at once while the program runs, and later while it is paused."""
        await self._gate.wait()

    async def _run(self, program: Program) -> None:
        try:
            await program.run(self._box)
        except asyncio.CancelledError:
            pass  # stopped
        except Tool0Error as error:
            self._box.report(error)
        except Exception as error:
            logger.exception("the program '%s' failed", program.name)
            self._box.messages.error(f"{program.name}: {error!r}")
        finally:
            await asyncio.shield(self._end())

    async def _end(self) -> None:
        try:
            await self._box.call(ReturnArm(arm=self._box.arm))
        except Tool0Error as error:
            self._box.report(error)
        self._task = None
        self._gate.set()
        self.state = RuntimeState.STOPPED
        self._box.messages.program("")
