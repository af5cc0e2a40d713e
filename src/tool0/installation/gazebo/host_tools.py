"""Running the host's own programs, which end when we do, however we end."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from tool0.errors import EngineUnavailableError

PATIENCE = 0.1
"""Wall seconds between two looks at a running program."""


def run_host(
    command: Sequence[str],
    *,
    folder: Path | None = None,
    while_running: Callable[[], None] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run a program of the host to its end; the caller looks at its status.

    Args:
        command: The program and its arguments.
        folder: Where it runs.
        while_running: Called now and then until it has ended.

    Raises:
        EngineUnavailableError: If there is no such program.
    """
    if shutil.which(command[0]) is None:
        raise EngineUnavailableError(f"this machine has no program '{command[0]}'")
    with subprocess.Popen(
        tied(command),
        cwd=folder,
        env={**os.environ, "LC_ALL": "C"},  # its messages are read
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
    ) as process:
        try:
            while True:
                try:
                    out, err = process.communicate(
                        timeout=None if while_running is None else PATIENCE
                    )
                    break
                except subprocess.TimeoutExpired:
                    assert while_running is not None  # only then is there a time-out
                    while_running()
        except BaseException:
            process.terminate()
            raise
    return subprocess.CompletedProcess(command, process.returncode, out, err)


def tied(command: Sequence[str]) -> list[str]:
    """Return the command such that the kernel ends it when our process is killed."""
    setpriv = shutil.which("setpriv")  # of util-linux, on every Debian and Ubuntu
    return [*([setpriv, "--pdeathsig", "TERM"] if setpriv else []), *command]


def last_lines(text: str, count: int = 6) -> str:
    """Return the end of what a program said, indented, to be shown in a message."""
    lines = [line for line in text.splitlines() if line.strip()]
    return "\n".join(f"  {line}" for line in lines[-count:])
