"""The logs of gzserver and gzclient, and reports of how they ended."""

from __future__ import annotations

import re
import signal
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from tool0.installation.child_process import ChildProcess

_LAST_LINES: Final = 12
_COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
_NOISE: Final = re.compile(
    r"$|Gazebo multi-robot simulator|Copyright|Released under|http://gazebosim"
    r"|\[Msg\]|\[\w+\] \[RenderEngine"  # which draws nothing without a display
    r"|Error:\s+Could not find the 'robot'"  # before it tries SDF
)
"""Lines that every gzserver prints, and that never explain a failure."""
_ERROR: Final = re.compile(r"\[Err\]|Error|\[Wrn\] \[Server")


def exit_report(why: str, process: ChildProcess | None, log: Path) -> str:
    """Return ``why``, how ``process`` ended if it did, and the end of its log."""
    status = None if process is None else process.exit_status
    if status is None:
        how = ""
    elif status < 0:
        how = f", killed by {signal.Signals(-status).name}"
    else:
        how = f", exit status {status}"
    lines = "".join(f"\n  {line}" for line in log_lines(log)[-_LAST_LINES:])
    end = f"; the end of its log:{lines}" if lines else "; its log is empty"
    return f"{why}{how}{end}"


def log_lines(log: Path) -> list[str]:
    """Return the lines of a log without colours and without what is always there."""
    try:
        text = log.read_text(errors="replace")
    except OSError:
        return []
    lines = (line.rstrip() for line in _COLOUR.sub("", text).splitlines())
    return [line for line in lines if not _NOISE.match(line)]


def error_lines(lines: Iterable[str]) -> list[str]:
    """Return those lines that report an error."""
    return [line for line in lines if _ERROR.match(line)]
