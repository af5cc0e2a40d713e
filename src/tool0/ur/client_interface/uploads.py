"""Executes the programs that clients send, one after another."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Final, final

from tool0.errors import ControlError, Tool0Error
from tool0.protocol.control_box import (
    PowerOff,
    PowerOn,
    ReleaseBrakes,
    UnlockProtectiveStop,
)
from tool0.ur.client_interface.scripts import UNNAMED, Script
from tool0.ur.compiling import compiled

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox
    from tool0.ur.programs import RunnableProgram

logger = logging.getLogger(__name__)

MAX_WAITING: Final = 32
"""Maximum number of queued programs. A program that is received when the queue is full
replaces the oldest queued program. The start of the new program would end the oldest
program anyway."""
MAX_SECONDARY: Final = 16
"""Maximum number of secondary programs that run at the same time."""


@final
class Uploads:
    """Executes scripts. A script that is not secondary replaces the current program."""

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._waiting: deque[tuple[Script, int]] = deque()
        """Queued scripts, and for each script the number of stops before it was
        received."""
        self._arrived = asyncio.Event()
        self._is_flooded = False
        self._secondary: set[asyncio.Task[None]] = set()
        self._stopping: set[asyncio.Task[None]] = set()
        self._task = asyncio.create_task(self._execute_all())
        arm = box.arm
        self._commands: dict[str, Callable[[], Awaitable[object]]] = {
            "power on": lambda: box.call(PowerOn(arm=arm)),
            "set robotmode run": lambda: box.call(ReleaseBrakes(arm=arm)),
            "set unlock protective stop": lambda: box.call(
                UnlockProtectiveStop(arm=arm, at_once=True)
            ),
        }
        """Handlers of lines that are not URScript but that UR's own client library
        sends."""
        self._stops: dict[str, Callable[[], Awaitable[object]]] = {
            "power off": self._power_off,
            "stop program": box.programs.stop,
        }
        """Handlers of commands that are executed immediately, before queued scripts."""

    def put(self, script: Script) -> None:
        """Add a script to the queue, or execute it immediately if it is a stop."""
        if (stop := self._stops.get(_line(script))) is not None:
            task = asyncio.create_task(self._attempt(script, stop()))
            self._stopping.add(task)
            task.add_done_callback(self._stopping.discard)
            return
        if len(self._waiting) >= MAX_WAITING:
            self._waiting.popleft()
            if not self._is_flooded:
                self._is_flooded = True
                self._box.report(
                    ControlError("programs arrive faster than they can be started")
                )
        self._waiting.append((script, self._box.programs.n_stops))
        self._arrived.set()

    async def close(self) -> None:
        """End the secondary programs and discard the queued scripts."""
        tasks = (self._task, *self._secondary, *self._stopping)
        for task in tasks:
            task.cancel()
        await asyncio.wait(tasks)

    async def _execute_all(self) -> None:
        while True:
            while not self._waiting:
                self._is_flooded = False
                self._arrived.clear()
                await self._arrived.wait()
            script, n_stops = self._waiting.popleft()
            await self._attempt(script, self._execute(script, n_stops))

    async def _attempt(self, script: Script, execution: Awaitable[object]) -> None:
        """Execute a script and report its errors; other scripts are not affected."""
        try:
            await execution
        except Tool0Error as error:
            self._box.report(error)
        except Exception as error:
            logger.exception("the program '%s' could not be started", script.name)
            self._box.messages.error(f"{script.name}: {error!r}")

    def _power_off(self) -> Awaitable[object]:
        """Switch the arm off and discard the scripts that were received before."""
        self._box.programs.n_stops += 1
        return self._box.call(PowerOff(arm=self._box.arm))

    async def _execute(self, script: Script, n_stops: int) -> None:
        self._box.programs.require_no_stop(script.name, n_stops)
        command = self._commands.get(_line(script))
        if command is not None:
            await command()
            return
        program = await compiled(script.text, script.name)
        if not script.is_secondary:
            await self._box.programs.start(program, n_stops)
            return
        if len(self._secondary) >= MAX_SECONDARY:
            raise ControlError(
                f"{script.name}: {MAX_SECONDARY} secondary programs are running already"
            )
        task = asyncio.create_task(self._run_beside(program))
        self._secondary.add(task)
        task.add_done_callback(self._secondary.discard)

    async def _run_beside(self, program: RunnableProgram[UrControlBox]) -> None:
        """Run a secondary program, which cannot move the arm."""
        try:
            await program.run(self._box)
        except Tool0Error as error:
            self._box.report(error)
        except Exception as error:
            logger.exception("the program '%s' failed", program.name)
            self._box.messages.error(f"{program.name}: {error!r}")


def _line(script: Script) -> str:
    """Return the line of an unnamed script in lower case; empty for a named script."""
    return " ".join(script.text.split()).lower() if script.name == UNNAMED else ""
