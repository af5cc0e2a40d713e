"""The interpreter mode, over its port."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any, cast

import pytest
from document import blocks
from urscript_rig import Run, TimeBox, run_on

from tool0.ur.interpreter_port import PORT, InterpreterPort

MODE = 'interpreter_mode()\ntextmsg("ended")'


class Client:
    """A client of the port."""

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self._reader, self._writer = reader, writer

    def send(self, *lines: str) -> None:
        self._writer.write("".join(f"{line}\n" for line in lines).encode())

    async def reply(self) -> str:
        return (await self._reader.readline()).decode().removesuffix("\n")

    async def ask(self, line: str) -> str:
        self.send(line)
        return await self.reply()

    async def until_executed(self, number: int) -> None:
        while await self.ask("statelastexecuted") != (
            f"state: {number}: statelastexecuted"
        ):
            pass

    def close(self) -> None:
        self._writer.close()


Talk = Callable[[Client, TimeBox], Coroutine[Any, Any, None]]


def run_with(program: str | None, talk: Talk) -> Run:
    """Talk to the port while a program runs, which ends by itself."""

    async def run() -> Run:
        box = TimeBox()
        shared = cast("Any", box)
        with socket.create_server(("127.0.0.1", 0)) as free:
            number = free.getsockname()[1]
        port = InterpreterPort(shared)
        await port.start("127.0.0.1", number - PORT)
        client = Client(*await asyncio.open_connection("127.0.0.1", number))
        try:
            if program is None:
                await talk(client, box)
                return Run()
            task = asyncio.create_task(run_on(shared, program))
            while box.interpreter is None and not task.done():
                await asyncio.sleep(0)
            await talk(client, box)
            return await task
        finally:
            client.close()
            await port.close()

    return asyncio.run(asyncio.wait_for(run(), 20.0))


def test_statements_are_acknowledged_and_executed_in_order() -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        assert await client.ask("x = 2") == "ack: 1: x = 2"
        line = "def double(a): b = 2 * a textmsg(b) return b end"
        assert await client.ask(line) == f"ack: 2: {line}"
        assert await client.ask("x = double(x) y = x + 1") == (
            "ack: 3: x = double(x) y = x + 1"
        )
        assert await client.ask("textmsg(x, y)") == "ack: 4: textmsg(x, y)"
        await client.until_executed(4)
        assert await client.ask("statelastinterpreted") == (
            "state: 4: statelastinterpreted"
        )
        assert await client.ask("stateunexecuted") == "state: 0: stateunexecuted"
        assert await client.ask("end_interpreter()") == "ack: 5: end_interpreter()"

    run = run_with(MODE, talk)
    assert (run.error, run.texts) == (None, ["4", "45", "ended"])


def test_the_dialogue_of_the_page_takes_place() -> None:
    page = Path(__file__).parents[4] / "docs/how-to/urscript.md"
    (text,) = (b.text for b in blocks(page) if b.title == "interpreter")
    lines = text.splitlines()

    async def talk(client: Client, box: TimeBox) -> None:
        for asked, told in zip(lines[::2], lines[1::2], strict=True):
            if "statelastexecuted" in asked:
                await client.until_executed(2)
            assert f"< {await client.ask(asked.removeprefix('> '))}" == told

    assert run_with(MODE, talk).texts == ["8", "ended"]


def test_statements_see_the_scope_that_called() -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        await client.ask("a = helper(a)")
        await client.ask("g = g + 1")
        await client.ask("new = 7")
        await client.ask("end_interpreter()")

    run = run_with(
        """
        g = 1
        def helper(x):
          return x * 10
        end
        def work(a):
          interpreter_mode()
          textmsg(a)
        end
        work(3)
        textmsg(g)
        """,
        talk,
    )
    assert (run.error, run.texts) == (None, ["30", "2"])


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("x =", "unexpected end of the line; expected a value (line 1, column 3)"),
        ("textmsg(unknown)", "unknown variable 'unknown' (line 1, column 9)"),
        ("interpreter_mode()", "interpreter modes are not nested (line 1, column 1)"),
    ],
)
def test_what_cannot_be_compiled_is_discarded(line: str, reason: str) -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        assert await client.ask(line) == f"discard: {reason}: {line}"
        assert await client.ask("end_interpreter()") == "ack: 1: end_interpreter()"

    assert run_with(MODE, talk).texts == ["ended"]


def test_without_a_program_everything_is_discarded() -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        assert await client.ask("sync()") == "discard: no program is running: sync()"
        assert await client.ask("stateunexecuted") == "state: 0: stateunexecuted"

    run_with(None, talk)


def test_what_came_before_the_mode_is_discarded_or_executed() -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        client.send('textmsg("early")')
        box.registers.inputs.integers[0] = 1
        assert await client.reply() == (
            'discard: cleared when the interpreter mode began: textmsg("early")'
        )
        assert await client.ask("end_interpreter()") == "ack: 1: end_interpreter()"
        assert await client.ask('textmsg("late")') == 'ack: 2: textmsg("late")'
        assert await client.ask("end_interpreter()") == "ack: 3: end_interpreter()"

    wait = "while read_input_integer_register(0) == 0:\nsync()\nend\n"
    run = run_with(
        f'{wait}sleep(1)\n{MODE}\nsleep(1)\ninterpreter_mode(False)\ntextmsg("2")', talk
    )
    assert run.texts == ["ended", "late", "2"]


def test_skipped_statements_are_not_executed() -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        wait = "while read_input_integer_register(0) == 0: sync() end"
        client.send(wait, *(f"textmsg({k})" for k in range(3)))
        for _ in range(4):
            assert (await client.reply()).startswith("ack: ")
        assert await client.ask("stateunexecuted") == "state: 3: stateunexecuted"
        assert (await client.ask("skipbuffer")).startswith("ack: ")
        assert await client.ask("stateunexecuted") == "state: 0: stateunexecuted"
        box.registers.inputs.integers[0] = 1
        await client.ask("end_interpreter()")

    assert run_with(MODE, talk).texts == ["ended"]


def test_clearing_forgets_functions_variables_and_threads() -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        await client.ask("def f(): return 1 end")
        await client.ask("thread t(): while True: sync() kept = kept + 1 end end")
        await client.ask("x = f() run t()")
        client.send("clear_interpreter()", "textmsg(x)", "x = f()", "kept = 0")
        assert await client.reply() == "ack: 4: clear_interpreter()"
        assert (await client.reply()).startswith("discard: unknown variable 'x'")
        assert (await client.reply()).startswith("discard: unknown function 'f'")
        assert await client.reply() == "ack: 5: kept = 0"
        assert await client.ask("statelastcleared") == "state: 4: statelastcleared"
        await client.ask("sync() sync() textmsg(kept)")
        await client.ask("end_interpreter()")

    assert run_with("kept = 0\n" + MODE, talk).texts == ["0", "ended"]


def test_what_is_kept_is_there_in_the_next_mode() -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        await client.ask("def f(): return 5 end")
        await client.ask("end_interpreter()")
        await client.ask("textmsg(f())")
        await client.ask("end_interpreter()")

    program = "interpreter_mode(clearOnEnd = False)\ninterpreter_mode(False)"
    run = run_with(program, talk)
    assert (run.error, run.texts) == (None, ["5"])


def test_a_thread_of_the_program_can_end_the_mode() -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        await client.ask("enough = True")

    run = run_with(
        """
        enough = False
        thread watch():
          while not enough:
            sync()
          end
          end_interpreter()
        end
        run watch()
        """
        + MODE,
        talk,
    )
    assert run.texts == ["ended"]


def test_a_statement_that_fails_ends_the_program_and_what_waits() -> None:
    async def talk(client: Client, box: TimeBox) -> None:
        assert await client.ask("x = 0") == "ack: 1: x = 0"
        assert await client.ask("y = 1 / x") == "ack: 2: y = 1 / x"

    run = run_with(MODE, talk)
    assert str(run.error) == "interpreter:1:7: division by zero"
