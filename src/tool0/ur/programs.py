"""The program of a control box. Only one program at a time controls the arm."""

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
    """State of the program; the values are RTDE's numbers."""

    STOPPING = 0
    STOPPED = 1
    PLAYING = 2
    PAUSING = 3
    PAUSED = 4
    RESUMING = 5


class Holder(Protocol):
    """The part of a control box that ``ProgramSlot`` uses."""

    arm: str
    messages: Messages

    async def call(self, request: Request[Any]) -> Any:
        """Return the response; raise an error if the request fails."""

    def send(self, request: Request[Any]) -> None:
        """Send a request without waiting for the response."""

    def report(self, error: Tool0Error) -> None:
        """Report an error to the clients and in the log."""


BoxT = TypeVar("BoxT", bound=Holder)
Box_contra = TypeVar("Box_contra", contravariant=True)


class RunnableProgram(Protocol[Box_contra]):
    """A program that can run on a control box."""

    @property
    def name(self) -> str: ...

    async def run(self, box: Box_contra) -> None:
        """Run the program to its end; to stop it, cancel the call.

        Raises:
            Tool0Error: If the program fails; the message contains the reason.
        """


class LineInterpreter(Protocol):
    """The part of a running program that executes lines from clients."""

    def submit(self, text: str, reply: Callable[[str], None]) -> None:
        """Accept a line and reply to it immediately or later."""


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
        """Whether an update has shown that the program controls the arm."""
        self.state = RuntimeState.STOPPED
        self.name = ""
        """Name of the current or last program."""
        self.n_stops = 0
        """Number of stops since the start. A program that was sent before the last stop
        is not started."""
        self._n_stops_before = 0
        """Number of stops before the current program was sent."""

    @property
    def is_running(self) -> bool:
        """Whether there is an active program, which may be paused."""
        return self._task is not None

    @property
    def is_paused(self) -> bool:
        """Whether the program is paused."""
        return self.state in {RuntimeState.PAUSING, RuntimeState.PAUSED}

    def require_no_stop(self, name: str, n_stops: int) -> None:
        """Raise ControlError if ``n_stops`` is not the current number of stops."""
        if n_stops != self.n_stops:
            raise ControlError(
                f"{name}: not started, since a stop came after it; send it again"
            )

    async def start(self, program: RunnableProgram[BoxT], n_stops: int) -> None:
        """Start a program, which replaces the current program and stops its motion.

        Args:
            program: The program.
            n_stops: The value of ``self.n_stops`` when the program was sent.

        Raises:
            ControlError: If the arm cannot move or has been stopped in the meantime.
        """
        arm = self._box.arm
        async with self._changing:
            self.require_no_stop(program.name, n_stops)
            was_running = await self._cancel()
            try:
                if was_running:  # the arm remains claimed
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
        """Discard earlier programs; when awaited, stop the program and the arm.

        Programs that are sent after this call start normally, even if the returned
        coroutine has not been awaited.
        """
        self.n_stops += 1
        return self._stop(self.n_stops)

    async def _stop(self, number: int) -> None:
        async with self._changing:
            if self._n_stops_before < number and await self._cancel():
                await self._release()
                self._box.messages.program("")

    def pause(self) -> None:
        """Pause the program at its next statement, and pause its motion.

        Raises:
            ControlError: If no program is running.
        """
        if self.state is not RuntimeState.PLAYING:
            raise ControlError("no program is running")
        self._gate.clear()
        self.state = RuntimeState.PAUSING
        self._box.send(PauseProgram(arm=self._box.arm))

    def resume(self) -> None:
        """Continue a paused program.

        Raises:
            ControlError: If no program is paused.
        """
        if not self.is_paused:
            raise ControlError("no program is paused")
        self.state = RuntimeState.RESUMING
        self._box.send(PlayProgram(arm=self._box.arm))

    def follow(self, state: ControlBoxState) -> bool:
        """Apply changes that other clients made to the control box, such as a pause.

        Return whether the program has lost control of the arm and must end.
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
        """Wait while the program is paused; otherwise, return immediately."""
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
            self._task = None  # the task can no longer be canceled
            await self._release()
            self._box.messages.program("")

    async def _cancel(self) -> bool:
        """End the current program; return whether a program was ended."""
        task = self._task
        if task is None or task is asyncio.current_task():
            return False
        self.state = RuntimeState.STOPPING
        task.cancel()
        await asyncio.wait([task])
        self._task = None
        return True

    async def _release(self) -> None:
        """Return the arm to its controllers."""
        try:
            await self._box.call(ReturnArm(arm=self._box.arm))
        except Tool0Error as error:
            self._box.report(error)
        self._gate.set()
        self.state = RuntimeState.STOPPED
