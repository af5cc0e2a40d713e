"""The program of a control box: one at a time has the arm."""

from __future__ import annotations

import asyncio
import logging
from enum import IntEnum
from typing import TYPE_CHECKING, Protocol, final

from tool0.errors import ControlError, Tool0Error
from tool0.requests.arm_motion import ReturnArm, StopArm, TakeArm

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
        self._changing = asyncio.Lock()
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
        """Start a program; it replaces the one that runs, whose motion stops.

        Raises:
            ControlError: If the arm may not move now.
        """
        arm = self._box.arm
        async with self._changing:
            was_running = await self._cancel()
            try:
                if was_running:  # the arm stays taken
                    self._box.messages.program("")
                    await self._box.call(StopArm(arm=arm))
                await self._box.call(TakeArm(arm=arm, by=program.name))
            except Tool0Error:
                await self._release()
                raise
            self.name = program.name
            self.state = RuntimeState.PLAYING
            self._gate.set()
            self._box.messages.program(program.name)
            self._task = asyncio.create_task(self._run(program))

    async def stop(self) -> None:
        """Stop the program and the arm; without a program, do nothing."""
        async with self._changing:
            if await self._cancel():
                await self._release()
                self._box.messages.program("")

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
        except Tool0Error as error:
            self._box.report(error)
        except Exception as error:
            logger.exception("the program '%s' failed", program.name)
            self._box.messages.error(f"{program.name}: {error!r}")
        async with self._changing:
            self._task = None  # it can no longer be cancelled
            await self._release()
            self._box.messages.program("")

    async def _cancel(self) -> bool:
        """End the program that runs; return whether there was one."""
        task = self._task
        if task is None or task is asyncio.current_task():
            return False
        self.state = RuntimeState.STOPPING
        task.cancel()
        await asyncio.wait([task])
        self._task = None
        return True

    async def _release(self) -> None:
        """Give the arm back."""
        try:
            await self._box.call(ReturnArm(arm=self._box.arm))
        except Tool0Error as error:
            self._box.report(error)
        self._gate.set()
        self.state = RuntimeState.STOPPED
