"""The program of a control box: one at a time has the arm."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Coroutine
from enum import IntEnum
from typing import Any, Generic, Protocol, TypeVar, final

from tool0.errors import ControlError, Tool0Error
from tool0.protocol.arm_motion import ReturnArm, StopArm, TakeArm
from tool0.protocol.control_box import PauseProgram, PlayProgram
from tool0.protocol.control_box_state import ControlBoxState, ProgramState
from tool0.protocol.request import Request
from tool0.ur.messages import Messages

logger = logging.getLogger(__name__)


class RuntimeState(IntEnum):
    """The state of the program, by the numbers of RTDE."""

    STOPPING = 0
    STOPPED = 1
    PLAYING = 2
    PAUSING = 3
    PAUSED = 4
    RESUMING = 5


class Holder(Protocol):
    """The part of a control box that the slot uses."""

    arm: str
    messages: Messages

    async def call(self, request: Request[Any]) -> Any:
        """Return the response, or raise the error."""

    def send(self, request: Request[Any]) -> None:
        """Send a request of which no answer is needed."""

    def report(self, error: Tool0Error) -> None:
        """Tell clients and the log about an error."""


BoxT = TypeVar("BoxT", bound=Holder)
Box_contra = TypeVar("Box_contra", contravariant=True)


class RunnableProgram(Protocol[Box_contra]):
    """A program that can run on a control box."""

    @property
    def name(self) -> str: ...

    async def run(self, box: Box_contra) -> None:
        """Run to the end; it is cancelled to be stopped.

        Raises:
            Tool0Error: If the program fails, with the reason.
        """


class LineInterpreter(Protocol):
    """The part of a running program that takes lines of clients."""

    def submit(self, text: str, reply: Callable[[str], None]) -> None:
        """Take a line, and reply to it now or later."""


@final
class ProgramSlot(Generic[BoxT]):
    """Starts, pauses and stops the program of one control box."""

    def __init__(self, box: BoxT) -> None:
        self._box = box
        self._task: asyncio.Task[None] | None = None
        self._changing = asyncio.Lock()
        self._gate = asyncio.Event()
        self._gate.set()
        self._has_arm = False
        """Whether updates have shown that the program has the arm."""
        self.state = RuntimeState.STOPPED
        self.name = ""
        """Name of the program that runs, or ran last."""
        self.n_stops = 0
        """A program that was sent before the last stop is not started after it."""
        self._n_stops_before = 0
        """Stops before the program that runs was sent."""

    @property
    def is_running(self) -> bool:
        """Whether there is a program, running or paused."""
        return self._task is not None

    @property
    def is_paused(self) -> bool:
        """Whether a program waits to be resumed."""
        return self.state in {RuntimeState.PAUSING, RuntimeState.PAUSED}

    def require_no_stop(self, name: str, n_stops: int) -> None:
        """Raise ControlError if a stop came after the first ``n_stops``."""
        if n_stops != self.n_stops:
            raise ControlError(
                f"{name}: not started, since a stop came after it; send it again"
            )

    async def start(self, program: RunnableProgram[BoxT], n_stops: int) -> None:
        """Start a program; it replaces the one that runs, whose motion stops.

        Args:
            program: The program.
            n_stops: The stops so far when it was sent.

        Raises:
            ControlError: If the arm may not move now, or was stopped meanwhile.
        """
        arm = self._box.arm
        async with self._changing:
            self.require_no_stop(program.name, n_stops)
            was_running = await self._cancel()
            try:
                if was_running:  # the arm stays taken
                    self._box.messages.program("")
                    await self._box.call(StopArm(arm=arm))
                await self._box.call(TakeArm(arm=arm, by=program.name, protected=True))
            except Tool0Error:
                await self._release()
                raise
            self.name = program.name
            self._n_stops_before = n_stops
            self.state = RuntimeState.PLAYING
            self._gate.set()
            self._box.messages.program(program.name)
            self._task = asyncio.create_task(self._run(program))

    def stop(self) -> Coroutine[Any, Any, None]:
        """Stop the program and the arm, when awaited, and start none sent before.

        What is sent after this call is started, also if this is not awaited yet.
        """
        self.n_stops += 1
        return self._stop(self.n_stops)

    async def _stop(self, number: int) -> None:
        async with self._changing:
            if self._n_stops_before < number and await self._cancel():
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
        self.state = RuntimeState.PAUSING
        self._box.send(PauseProgram(arm=self._box.arm))

    def resume(self) -> None:
        """Continue a paused program.

        Raises:
            ControlError: If none is paused.
        """
        if not self.is_paused:
            raise ControlError("no program is paused")
        self.state = RuntimeState.RESUMING
        self._box.send(PlayProgram(arm=self._box.arm))

    def follow(self, state: ControlBoxState) -> bool:
        """Follow what others did with the control box: pause and resume.

        Return whether the program has lost the arm, and must end.
        """
        if not self.is_running:
            self._has_arm = False
            return False
        if state.taken_by:
            self._has_arm = True
        elif self._has_arm:
            return True
        if state.program is ProgramState.PAUSED:
            if self.state in {RuntimeState.PLAYING, RuntimeState.PAUSING}:
                self._gate.clear()
                self.state = RuntimeState.PAUSED
        elif self.state in {RuntimeState.PAUSED, RuntimeState.RESUMING}:
            self._gate.set()
            self.state = RuntimeState.PLAYING
        return False

    async def gate(self) -> None:
        """Return at once while the program runs, and later while it is paused."""
        await self._gate.wait()

    async def _run(self, program: RunnableProgram[BoxT]) -> None:
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
