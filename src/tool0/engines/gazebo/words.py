"""What gzserver and gzclient said, and how they ended, for people."""

from __future__ import annotations

import re
import signal
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from tool0.installation.child_process import ChildProcess

_LAST_LINES: Final = 12
_COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
_CHATTER: Final = re.compile(
    r"$|Gazebo multi-robot simulator|Copyright|Released under|http://gazebosim"
    r"|\[Msg\]|\[\w+\] \[RenderEngine"  # which draws nothing without a display
    r"|Error:\s+Could not find the 'robot'"  # before it tries SDF
)
"""What every gzserver says, and what a reason is not among."""
_COMPLAINT: Final = re.compile(r"\[Err\]|Error|\[Wrn\] \[Server")


def obituary(why: str, process: ChildProcess | None, log: Path) -> str:
    """Return ``why``, how ``process`` ended if it did, and its last words."""
    status = None if process is None else process.exit_status
    if status is None:
        how = ""
    elif status < 0:
        how = f", killed by {signal.Signals(-status).name}"
    else:
        how = f", exit status {status}"
    words = "".join(f"\n  {line}" for line in said(log)[-_LAST_LINES:])
    last = f"; its last words:{words}" if words else "; it said nothing"
    return f"{why}{how}{last}"


def said(log: Path) -> list[str]:
    """Return the lines of a log without colours and without what is always said."""
    try:
        text = log.read_text(errors="replace")
    except OSError:
        return []
    lines = (line.rstrip() for line in _COLOUR.sub("", text).splitlines())
    return [line for line in lines if not _CHATTER.match(line)]


def complaints(lines: Iterable[str]) -> list[str]:
    """Return those lines that tell of an error."""
    return [line for line in lines if _COMPLAINT.match(line)]
