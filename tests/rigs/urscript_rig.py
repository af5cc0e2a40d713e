"""Runs URScript programs: on a bring-up's control box, or with time alone."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar, cast

from tool0.errors import Tool0Error
from tool0.protocol.arm import ListArms
from tool0.protocol.socket_channel import SocketChannel
from tool0.protocol.state import ArmSample, ArmSetpoint
from tool0.ur.control_box import UrControlBox, box_states
from tool0.ur.messages import Message, MessageKind, Messages
from tool0.ur.modbus.signals import Signals
from tool0.ur.programs import LineInterpreter
from tool0.ur.registers import N_FLAGS, Registers
from tool0.ur.rtde_sensor import RtdeSensor
from tool0.ur.urscript.program import compile_program

R = TypeVar("R")
PROGRAMS = Path(__file__).parents[1] / "data" / "urscript"
ZEROS = (0.0,) * 6
TIMEOUT = 60.0  # [wall s]


def is_error(message: Message) -> bool:
    return message.kind in {MessageKind.ERROR, MessageKind.EXCEPTION}


def error_text(message: Message) -> str:
    """Return an error as the log has it, without the program's name."""
    if message.kind is MessageKind.ERROR:
        return message.text
    line, column = message.place
    return f"{line}:{column}: {message.text}"


@dataclass
class Run:
    """What a program did."""

    messages: list[Message] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    """Of the messages, since the start [s]."""
    error: Tool0Error | None = None
    duration: float = 0.0
    """Simulated [s]."""

    @property
    def texts(self) -> list[str]:
        return [item.text for item in self.messages if item.kind is MessageKind.TEXT]

    @property
    def errors(self) -> list[str]:
        return [error_text(item) for item in self.messages if is_error(item)]

    def time_of(self, text: str, which: int = 0) -> float:
        """When a text was sent, since the start [s]."""
        pairs = zip(self.messages, self.times, strict=True)
        return [time for item, time in pairs if item.text == text][which]


class _Slot:
    is_paused = False

    def __init__(self, box: TimeBox) -> None:
        self._box = box

    def pause(self) -> None:
        self.is_paused = True

    def resume(self) -> None:
        self.is_paused = False

    async def gate(self) -> None:
        while self.is_paused:
            await self._box.next_update()


class TimeBox:
    """A control box whose time passes when a program waits; nothing moves."""

    arm = "arm"
    rate = 500.0
    allow_sockets = False
    gripper, why_no_gripper = None, "the arm carries no gripper"
    sensed_wrench = q = qd = effort = tcp = target_q = target_qd = ZEROS

    def __init__(self) -> None:
        self.ticks = 0
        self.messages = Messages()
        self.registers = Registers()
        self.flags = [False] * N_FLAGS
        self.programs = _Slot(self)
        self.modbus = Signals(lambda: True)
        self.rtde_sensor = RtdeSensor()
        self.encoders: dict[int, tuple[range, float]] = {}
        self.interpreter: LineInterpreter | None = None
        self.when_updated: set[Callable[[], None]] = set()
        self.arm_sample = ArmSample(
            mode="hold",
            setpoint=ArmSetpoint(ZEROS, ZEROS, ZEROS),
            path=0,
            path_time=0.0,
            is_done=True,
            force_mode=False,
            wrench=ZEROS,
        )
        self._next: asyncio.Future[None] | None = None

    def report(self, error: Tool0Error) -> None:
        self.messages.error(str(error))

    @property
    def time(self) -> float:
        return self.ticks * 0.002

    async def next_update(self) -> None:
        loop = asyncio.get_running_loop()
        if self._next is None:
            self._next = loop.create_future()
            loop.call_soon(self._advance, 2)
        await asyncio.shield(self._next)

    def _advance(self, turns: int) -> None:
        """Let every task that can run do so before time passes."""
        if turns:
            asyncio.get_running_loop().call_soon(self._advance, turns - 1)
            return
        self.ticks += 1
        for callback in tuple(self.when_updated):
            callback()
        waiting, self._next = self._next, None
        if waiting is not None:
            waiting.set_result(None)

    async def until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            await self.next_update()


def run_in_time(text: str, box: TimeBox | None = None) -> Run:
    """Run a program that needs no robot."""

    async def run() -> Run:
        return await run_on(cast("UrControlBox", box or TimeBox()), text)

    return asyncio.run(run())


async def run_on(box: UrControlBox, text: str, name: str = "p") -> Run:
    """Run a program on a box, without taking the arm."""
    outcome = Run()
    box.messages.listeners.add(outcome.messages.append)
    start = box.time
    try:
        program = compile_program(text, name)
        await program.run(box)
    except Tool0Error as error:
        outcome.error = error
    finally:
        box.messages.listeners.discard(outcome.messages.append)
    outcome.duration = box.time - start
    return outcome


class BoxRig:
    """The control box of a bring-up, in an event loop of its own thread."""

    def __init__(self, name: str = "tool0") -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._channel = SocketChannel(name)
        self.box = self.do(self._connect())

    def do(self, action: Coroutine[Any, Any, R]) -> R:
        """Await something in the loop."""
        return self.start(action).result(TIMEOUT)

    def start(self, action: Coroutine[Any, Any, R]) -> Future[R]:
        """Start something in the loop."""
        return asyncio.run_coroutine_threadsafe(action, self._loop)

    async def _connect(self) -> UrControlBox:
        boxes: list[UrControlBox] = []

        def take() -> None:
            for snapshot in subscription.pending() if boxes else ():
                boxes[0].take(snapshot)

        def in_loop() -> None:
            with suppress(RuntimeError):
                self._loop.call_soon_threadsafe(take)

        channel = self._channel

        def refuse(error: Tool0Error) -> None:
            self._loop.call_soon_threadsafe(boxes[0].report, error)

        channel.when_refused = refuse
        (arm,) = await asyncio.to_thread(channel.call, ListArms())
        subscription = await asyncio.to_thread(
            channel.follow, box_states([arm.name]), when_published=in_loop
        )
        first = await asyncio.to_thread(subscription.next)
        boxes.append(UrControlBox(channel, arm.name, first))
        return boxes[0]

    def run(self, text: str) -> Run:
        """Run a program as clients do, in the slot of the box."""
        return self.do(self._run(text))

    async def _run(self, text: str) -> Run:
        box, outcome = self.box, Run()
        start = box.time

        def listen(message: Message) -> None:
            outcome.messages.append(message)
            outcome.times.append(box.time - start)

        box.messages.listeners.add(listen)
        try:
            program = await asyncio.to_thread(compile_program, text, "p")
            await box.next_update()
            start = box.time
            await box.programs.start(program, box.programs.n_stops)
            while box.programs.is_running:
                await box.next_update()
            outcome.duration = box.time - start
        finally:
            box.messages.listeners.discard(listen)
        return outcome

    def close(self) -> None:
        if self.box.gripper is not None:
            self.do(self.box.gripper.close())
        self._channel.close()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()


@contextmanager
def box_rig(name: str = "tool0") -> Iterator[BoxRig]:
    rig = BoxRig(name)
    try:
        yield rig
    finally:
        rig.close()
