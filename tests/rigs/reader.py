"""A reader of a tutorial: saves its files, and types its commands in terminals."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from document import Block
from ros import free_port
from waits import until

LONGEST = 240.0
"""For one command, on a busy machine [wall s]."""
SAVED = ("xml", "yaml", "python")
"""Blocks that the reader saves as files."""
FIRST = "first-terminal"
OTHER_MACHINE = "noetic"
"""A terminal there does not see the bring-ups of the other ones."""
_LASTING = re.compile(r"(cd|eval|export|source) |[a-z_]+=")
"""Commands that change the shell: they hold for what is typed after them."""
_SERVER = re.compile(r"tool0 (bringup|replay|view)\b(?!.* --(json|simulate))")
"""Commands that go on until Ctrl-C."""
_UP = "Ctrl-C"
"""In the last line of what they print at the start."""
_PANEL = re.compile(r"http://127\.0\.0\.1:\d+/")
_XACRO = """#!/bin/sh
file=$1; shift
exec tool0 describe urdf --robot "$file" --args "$@"
"""
"""roslaunch calls it; a machine without Noetic has none that finds our packages."""


class Reader:
    """Follows one page in a folder; at the end, all its programs are ended.

    Args:
        folder: Empty, and short enough for the path of a socket.
        changed: Returns a command or a file as the test has it.
        variables: Further environment variables.
    """

    def __init__(
        self,
        folder: Path,
        changed: Callable[[str], str] = str,
        variables: Mapping[str, str] | None = None,
    ) -> None:
        programs = folder / ".bin"
        programs.mkdir()
        (programs / "xacro").write_text(_XACRO)
        (programs / "xacro").chmod(0o755)
        path = [str(programs), str(Path(sys.executable).parent), os.environ["PATH"]]
        self._folder, self._changed = folder, changed
        self._environ = {
            **{k: v for k, v in os.environ.items() if k != "DISPLAY"},
            "PATH": os.pathsep.join(path),
            "PYTHONUNBUFFERED": "1",
            "ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}",
            "ROS_HOME": str(folder / ".ros"),
            "ROS_LOG_DIR": str(folder / ".ros/log"),
            **(variables or {}),
        }
        self._terminals: dict[str, Terminal] = {}

    def follows(
        self, block: Block, skipped: Callable[[str], bool], *, fails: bool = False
    ) -> str:
        """Do what the block wants, but for skipped commands; return what it prints.

        Args:
            block: Any of the page.
            skipped: Whether a command is left out.
            fails: Whether the last command ends with a status other than 0.
        """
        if block.language in SAVED:
            file = self._folder / block.title
            file.write_text(self._changed(block.text), encoding="utf-8")
        if block.language != "sh":
            return ""
        terminal = self._terminal(block.title or FIRST)
        commands = [line for line in block.commands() if not skipped(line)]
        return "".join(
            terminal.types(
                self._changed(command), fails=fails and number == len(commands)
            )
            for number, command in enumerate(commands, start=1)
        )

    def _terminal(self, title: str) -> Terminal:
        if title not in self._terminals:
            runtime = self._folder / (
                ".elsewhere" if title == OTHER_MACHINE else ".run"
            )
            runtime.mkdir(mode=0o700, exist_ok=True)
            environ = {**self._environ, "XDG_RUNTIME_DIR": str(runtime)}
            self._terminals[title] = Terminal(self._folder, environ, title)
        return self._terminals[title]

    def __enter__(self) -> Reader:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with ExitStack() as ended:  # all of them, also if one ends badly
            for terminal in self._terminals.values():
                ended.callback(terminal.interrupts)


class Terminal:
    """A shell with at most one program that goes on, which the next command ends."""

    def __init__(self, folder: Path, environ: Mapping[str, str], title: str) -> None:
        self._folder, self._environ = folder, dict(environ)
        self._output = folder / f".{title}.txt"
        self._lasting = ["set -e"]
        self._server: subprocess.Popen[str] | None = None

    def types(self, command: str, *, fails: bool) -> str:
        """Return what the command prints; of one that goes on, until it is up."""
        self.interrupts()
        if _SERVER.match(command):
            return self._starts(command)
        done = subprocess.run(
            ["bash", "-c", "\n".join([*self._lasting, command])],
            cwd=self._folder,
            env=self._environ,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LONGEST,
            check=False,
        )
        assert (done.returncode != 0) == fails, f"{command}\n{done.stdout}"
        if _LASTING.match(command):
            self._lasting.append(command)
        return done.stdout

    def _starts(self, command: str) -> str:
        with self._output.open("w") as output:
            self._server = server = subprocess.Popen(
                ["bash", "-c", "\n".join([*self._lasting, f"exec {command}"])],
                cwd=self._folder,
                env=self._environ,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                text=True,
            )

        def is_up() -> bool:
            printed = self._output.read_text()
            assert server.poll() is None, f"{command}\n{printed}"
            return _UP in printed

        until(is_up, lambda: f"{command}\n{self._output.read_text()}", LONGEST)
        # The reader's own is at the usual port, that of the test at a free one.
        return _PANEL.sub("http://127.0.0.1:8085/", self._output.read_text())

    def interrupts(self) -> None:
        """Press Ctrl-C, if a program runs, and wait for its end."""
        server, self._server = self._server, None
        if server is None:
            return
        server.send_signal(signal.SIGINT)
        try:
            status = server.wait(LONGEST)
        except subprocess.TimeoutExpired:
            server.kill()
            raise
        assert status == 0, f"{status}\n{self._output.read_text()}"
