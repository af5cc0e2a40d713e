"""The control program of ur_rtde, which is a server for commands in registers.

The client writes a command and its arguments in one RTDE packet. A command is executed
once, and its state is then DONE until the client writes 0, which sets the state to
READY. Streamed commands are executed every time they are written, and the state remains
READY.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING, final

from tool0.errors import ControlError
from tool0.ur.rtde_control.commands import Commands
from tool0.ur.rtde_control.exchange import Exchange, State
from tool0.ur.rtde_control.script import ControlScript, parse
from tool0.ur.tool_contact import ToolHistory

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

NOTHING, STOP = 0, 255
"""Commands that all revisions of the program support."""


def recognise(text: str) -> RtdeControl | None:
    """Recognize ur_rtde's control program in a script; return None for other programs.

    Raises:
        ConfigError: If the script is ur_rtde's program, but contains a path that
            ur_rtde cannot have written.
    """
    script = parse(text)
    return None if script is None else RtdeControl(script)


@final
class RtdeControl:
    """An uploaded control program."""

    def __init__(self, script: ControlScript) -> None:
        self._script = script

    @property
    def name(self) -> str:
        return self._script.name

    async def run(self, box: UrControlBox) -> None:
        """Execute commands until the client stops the program.

        Raises:
            Tool0Error: If a command fails. The failure ends the program, as an error in
                URScript does.
        """
        with ToolHistory(box) as history:
            server = _CommandServer(box, self._script, history)
            with server.listening():
                await server.serve()


@final
class _CommandServer:
    """Executes the commands of a client."""

    def __init__(
        self, box: UrControlBox, script: ControlScript, history: ToolHistory
    ) -> None:
        self._box = box
        self._exchange = Exchange(box.registers, script.offset)
        self._wake = asyncio.Event()
        self._commands = Commands(
            box, self._exchange, history, script.path, self._wake.set
        )
        self._watchdog = _Watchdog()

    @contextlib.contextmanager
    def listening(self) -> Iterator[None]:
        """Return a context in which writing registers wakes the server."""
        self._box.registers.when_written.add(self._take)
        self._box.when_updated.add(self._look)
        try:
            yield
        finally:
            self._box.registers.when_written.discard(self._take)
            self._box.when_updated.discard(self._look)

    async def serve(self) -> None:
        """Execute commands until the client or the watchdog stops the program."""
        serving = asyncio.create_task(self._serve())
        watching = asyncio.create_task(self._watchdog.wait())
        tasks = {serving, watching}
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._commands.close()

    async def _serve(self) -> None:
        exchange, commands = self._exchange, self._commands
        is_executed = False
        exchange.show_progress(None)
        while True:
            self._wake.clear()
            command = exchange.command
            if command == STOP:
                return
            if commands.is_streamed(command):
                await commands.execute(command)
                exchange.tell(State.READY)
            elif command == NOTHING:
                is_executed = False
                exchange.tell(State.READY)
                await commands.look_for_contact()
            elif not is_executed:
                is_executed = True
                await commands.execute(command)
                if command == commands.SET_WATCHDOG:
                    self._watchdog.start(exchange.number(0))
                exchange.tell(State.DONE)
            await self._wake.wait()
            commands.check()
            await self._box.programs.gate()

    def _take(self, names: Collection[str]) -> None:
        """Wake the server for a command and restart the watchdog's timeout."""
        if self._exchange.command_name in names:
            self._exchange.written = names
            self._watchdog.kick()
            self._wake.set()

    def _look(self) -> None:
        """Wake the server at each update for commands that are polled."""
        if self._commands.is_polled(self._exchange.command):
            self._wake.set()


@final
class _Watchdog:
    """Raises an error if the client does not write a command within a timeout."""

    def __init__(self) -> None:
        self._is_set = asyncio.Event()
        self._timeout = 0.0
        self._last = 0.0

    def start(self, min_frequency: float) -> None:
        """Expect packets at a minimum rate [Hz]; 0 disables the watchdog."""
        self.kick()
        if min_frequency > 0.0:
            self._timeout = 1.0 / min_frequency
            self._is_set.set()
        else:
            self._is_set.clear()

    def kick(self) -> None:
        """Restart the timeout, because a packet has been received."""
        self._last = asyncio.get_running_loop().time()

    async def wait(self) -> None:
        """Wait until no packet has been received within the timeout.

        Raises:
            ControlError: If the timeout has expired.
        """
        loop = asyncio.get_running_loop()
        while True:
            await self._is_set.wait()
            remaining = self._last + self._timeout - loop.time()
            if remaining <= 0.0:
                raise ControlError(
                    "RTDE watchdog: the client wrote no command for "
                    f"{self._timeout:.3g} s; the program stops"
                )
            await asyncio.sleep(remaining)
