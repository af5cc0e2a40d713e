"""Mutated URScript programs, executed on a simulated arm, which is watched.

Whatever a program does, it ends with a message of its own or can be stopped; no joint
leaves its range, and none is faster than the arm's.
"""

from __future__ import annotations

import asyncio
import math
import random
import re
import struct
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pytest
from fuzzing import SCALE, SEED, Trial
from stepped_box import PERIOD, SteppedBox
from urscript_mutation import CALLS, corpus, mutated

import tool0
from tool0.description.payload import Payload
from tool0.errors import ControlError, Tool0Error
from tool0.ur.urscript.library.table import library
from tool0.ur.urscript.program import URScriptProgram, compile_program

N: Final = 40 * SCALE
"""Programs that are executed; about as many more are refused by the compiler."""
PER_ROBOT: Final = 200
PER_POSE: Final = 8
"""Programs until the robot is somewhere else; those between start where it is."""
ARMS: Final = ("ur5e", "ur3e", "ur5", "ur10e", "ur16e", "ur20")
DURATION: Final = 0.3
"""Of a program, which is stopped then [s]."""
MAX_TIME: Final = 10.0
"""Of the processor, for one program [s]."""
STOP_TIMEOUT: Final = 3.0
"""Until the arm was released [s]."""
MAX_EXCESS: Final = 0.02
"""Of a joint beyond its range [rad]."""
MAX_SPEED: Final = 1.25
"""Largest speed of a joint, as a part of that in the data sheet (docs/how-to/ur.md)."""
ROUNDING: Final = 1e-3
PUSHED: Final = 0.1
"""How long a contact counts [s]."""
POSES: Final = (
    (0.0, -1.2, 1.9, -2.2708, -1.5708, 0.0),
    (0.0, -1.57, 1.57, -1.57, -1.57, 0.0),
    (1.0, -0.8, 1.2, -0.4, 0.7, 2.0),
    (0.0, -1.57, 0.0, -1.57, 0.0, 0.0),
    (-2.0, -2.0, -1.5, -0.5, 1.5, -3.0),
)
"""In which no arm touches anything [rad]."""


@dataclass
class Largest:
    """The largest value that was seen, and what caused it."""

    value: float = -math.inf
    cause: str = ""

    def see(self, value: float, cause: str) -> None:
        if value > self.value:
            self.value, self.cause = value, cause


class Extremes:
    """How far joints were beyond their ranges [rad], and how fast."""

    def __init__(self) -> None:
        self.excess, self.speed = Largest(), Largest()

    def __str__(self) -> str:
        return f"{self.excess.value:.5f} rad, {self.speed.value:.5f}"


class Watch:
    """What the arm does, in all control periods."""

    def __init__(self) -> None:
        self.free = Extremes()
        self.pushed = Extremes()
        """Shortly after a contact, which no drive can limit."""
        self.misled = Extremes()
        """With another payload than declared: the drives push the arm, as a UR's do."""
        self.payload: Payload | None = None
        """The true one of the robot."""
        self._touched = -math.inf
        self.simulated = 0.0
        """[s]"""

    def look(self, stepped: SteppedBox, cause: str) -> None:
        self.simulated += PERIOD
        box, now = stepped.box, stepped.box.time
        if stepped.touches:
            self._touched = now
        kind = self.free
        if 0.0 <= now - self._touched < PUSHED:
            kind = self.pushed
        elif box.state.payload != self.payload:
            kind = self.misled
        q, qd = np.array(stepped.box.q), np.abs(stepped.box.qd)
        excess = np.maximum(stepped.lower - q, q - stepped.upper)
        joint = int(excess.argmax())
        kind.excess.see(float(excess[joint]), f"joint {joint}: {cause}")
        ratio = qd / stepped.fastest
        joint = int(ratio.argmax())
        kind.speed.see(float(ratio[joint]), f"joint {joint}: {cause}")


def test_the_corpus_calls_every_function() -> None:
    called = set(re.findall(r"\w+(?=\()", "\n".join(CALLS)))
    assert set(library()) <= called


@pytest.mark.timeout(600 + 10 * N)
def test_mutated_programs() -> None:
    trial, watch = Trial("URScript"), Watch()
    n_refused = 0
    for first in range(0, N, PER_ROBOT):
        number = SEED * N + first
        arm = ARMS[number // PER_ROBOT % len(ARMS)]
        with tool0.bringup(arm=arm, realtime=False, scene=scene_of(number)) as robot:
            count = min(PER_ROBOT, N - first)
            n_refused += asyncio.run(programs(robot, number, count, trial, watch))
    print(
        f"{n_refused} programs refused, {N} executed, {watch.simulated:.0f} s of the "
        f"robot; joints beyond their ranges, and parts of the largest speeds: "
        f"{watch.free}; with a contact {watch.pushed}; with a false payload "
        f"{watch.misled}"
    )
    trial.check()
    assert watch.free.excess.value <= MAX_EXCESS, watch.free.excess.cause
    assert watch.free.speed.value <= MAX_SPEED + ROUNDING, watch.free.speed.cause


def scene_of(number: int) -> str | None:
    return "table_and_cubes" if number // PER_ROBOT % 2 else None


async def programs(
    robot: tool0.Robot, first: int, count: int, trial: Trial, watch: Watch
) -> int:
    """Execute programs on a robot; return how many were refused."""
    stepped, run = SteppedBox(robot), Run(trial, watch)
    asyncio.get_running_loop().set_exception_handler(run.note_lost)
    watch.payload = stepped.box.state.payload
    texts, n_refused = corpus(), 0
    async with peer(random.Random(f"{first}.peer")) as port:
        for number in range(first, first + count):
            rng = random.Random(f"urscript.{number}")
            if number % PER_POSE == 0:
                move_elsewhere(robot, rng)
                await stepped.show()
            while True:
                run.text = text = mutated(rng, texts, port)
                if (program := compiled(text, trial)) is not None:
                    break
                n_refused += 1
            start = time.process_time()
            with trial.noting_logged(text):
                await run.execute(program, stepped, rng)
            if (taken := time.process_time() - start) > MAX_TIME:
                trial.note(TimeoutError(f"it took {taken:.1f} s"), text)
    await stepped.settle()
    stepped.close()
    return n_refused


def compiled(text: str, trial: Trial) -> URScriptProgram | None:
    """Return a program; None if the compiler refuses it, in whatever way."""
    found: list[URScriptProgram] = []
    trial.carry_out(lambda: found.append(compile_program(text)), text)
    return found[0] if found else None


def move_elsewhere(robot: tool0.Robot, rng: random.Random) -> None:
    """Put the robot into another pose, with joints near the ends of their ranges."""
    q = list(rng.choice(POSES))
    for joint in (0, 5):
        turns = rng.choice((-1, 0, 0, 1))
        q[joint] = max(-6.28, min(6.28, q[joint] + turns * 2.0 * math.pi))
    names = robot.arm.joints
    robot.arm.control_box.clear_payload()
    robot.reset(dict(zip(names, q, strict=True)))


class Run:
    """Executes programs one after the other."""

    def __init__(self, trial: Trial, watch: Watch) -> None:
        self._trial, self._watch = trial, watch
        self.text = ""
        """Of the program."""

    def note_lost(self, loop: asyncio.AbstractEventLoop, said: dict[str, Any]) -> None:
        """Note what nobody waits for."""
        error = said.get("exception") or RuntimeError(said["message"])
        self._trial.note(error, f"{said['message']}: {self.text}")

    async def execute(
        self, program: URScriptProgram, stepped: SteppedBox, rng: random.Random
    ) -> None:
        box = stepped.box
        if box.stopped or not box.state.may_move:
            control_box = stepped.robot.arm.control_box
            control_box.restart_safety()
            control_box.release_brakes()
            await stepped.show()
        if program.is_secondary:
            task = asyncio.ensure_future(self._beside(program, stepped))
            await self._until(task, stepped, DURATION)
            task.cancel()
            await self._until(task, stepped, STOP_TIMEOUT)
            await self._result(task)
            return
        start = asyncio.ensure_future(box.programs.start(program, box.programs.n_stops))
        await self._until(start, stepped, STOP_TIMEOUT)
        await self._result(start)
        for _ in range(round(DURATION / PERIOD)):
            if not box.programs.is_running:
                break
            self._disturb(stepped, rng)
            await self._step(stepped)
        stop = asyncio.ensure_future(box.programs.stop())
        await self._until(stop, stepped, STOP_TIMEOUT)
        await self._result(stop)
        for _ in range(round(STOP_TIMEOUT / PERIOD)):
            if not box.state.taken_by:
                break
            await self._step(stepped)
        else:
            self._trial.note(TimeoutError("the arm is not released"), self.text)

    async def _result(self, task: asyncio.Future[Any]) -> None:
        """Note how a task has failed, or that it goes on."""
        if not task.done():
            self._trial.note(TimeoutError("it does not end"), self.text)
            return
        try:
            await task
        except (Tool0Error, asyncio.CancelledError):
            pass
        except Exception as error:
            self._trial.note(error, self.text)

    async def _beside(self, program: URScriptProgram, stepped: SteppedBox) -> None:
        await program.run(stepped.box)

    def _disturb(self, stepped: SteppedBox, rng: random.Random) -> None:
        """Do now and then what other clients do meanwhile."""
        box, chance = stepped.box, rng.random()
        if box.interpreter is not None and chance < 0.1:
            box.interpreter.submit(rng.choice(CALLS), lambda line: None)
        elif chance < 0.001:
            with suppress(ControlError):
                box.programs.pause()
        elif box.programs.is_paused and chance < 0.05:
            with suppress(ControlError):
                box.programs.resume()
        elif chance < 0.003:
            stepped.robot.arm.control_box.set_speed_slider(rng.choice((0.0, 0.5, 1.0)))

    async def _until(
        self, task: asyncio.Future[Any], stepped: SteppedBox, timeout: float
    ) -> None:
        """Let time pass until a task has ended."""
        for _ in range(round(timeout / PERIOD)):
            if task.done():
                return
            await self._step(stepped)

    async def _step(self, stepped: SteppedBox) -> None:
        await stepped.step()
        self._watch.look(stepped, self.text)


@asynccontextmanager
async def peer(rng: random.Random) -> AsyncIterator[int]:
    """Serve what programs connect to, with answers at random; yield the port."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            while await reader.read(4096) and rng.random() < 0.9:
                writer.write(answer(rng))
        except (OSError, asyncio.CancelledError):
            pass  # Python 3.11 takes a cancelled callback of its streams for an error
        finally:
            writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    async with server:
        yield server.sockets[0].getsockname()[1]


def answer(rng: random.Random) -> bytes:
    """Return what a server of sockets, of XML-RPC or of Modbus could answer, or not."""
    numbers = [rng.choice((0.0, -1.5, 3.0, 1e300, math.nan)) for _ in range(6)]
    value = rng.choice(
        (
            "<int>5</int>",
            "<double>1e400</double>",
            "<string>a&#233;</string>",
            "<array><data><value><i8>99999999999</i8></value></data></array>",
            "<struct><member><name>x</name><value><nil/></value></member></struct>",
            "<boolean>2</boolean>",
        )
    )
    body = (
        "<?xml version='1.0'?><methodResponse><params><param><value>"
        f"{value}</value></param></params></methodResponse>"
    )
    match rng.randrange(6):
        case 0:
            return f"({', '.join(map(str, numbers))})\n".encode()
        case 1:
            return struct.pack(
                ">6i", *(rng.randrange(-1 << 31, 1 << 31) for _ in "123456")
            )
        case 2:
            return rng.randbytes(rng.randrange(1, 60))
        case 3:
            return b"<text>\\n" + b"x" * rng.randrange(2000)
        case 4:
            count = rng.randrange(1, 8)
            return struct.pack(">HHHBBB", 1, 0, 3 + 2 * count, 9, 3, 2 * count) + bytes(
                2 * count
            )
    head = f"HTTP/1.1 200 OK\r\nContent-Type: text/xml\r\nContent-Length: {len(body)}"
    return f"{head}\r\n\r\n{body}"[: rng.choice((None, None, 200))].encode()
