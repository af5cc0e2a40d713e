"""Other processes: whose they are, where they listen, when they end."""

from __future__ import annotations

import contextlib
import os
import select
import time
from collections.abc import Iterable
from pathlib import Path

_LISTENING = "0A"


class Watch:
    """Sees processes end, whoever's children they are."""

    def __init__(self, pids: Iterable[int]) -> None:
        self._open = {os.pidfd_open(pid) for pid in pids}
        assert self._open

    def all_ended(self, timeout: float) -> bool:
        """Wait at most `timeout` [wall s]; return whether none of them runs."""
        deadline = time.monotonic() + timeout
        while self._open:
            left = deadline - time.monotonic()
            ended, _, _ = select.select(list(self._open), [], [], max(left, 0.0))
            if not ended:
                return False
            for number in ended:
                self._open.remove(number)
                os.close(number)
        return True


def has_ended(pid: int, timeout: float) -> bool:
    """Wait at most `timeout` [wall s]; return whether the process does not run."""
    try:
        return Watch([pid]).all_ended(timeout)
    except ProcessLookupError:
        return True


def program(pid: int) -> str:
    """Return the name of the program that the process runs."""
    return Path(f"/proc/{pid}/exe").resolve().name


def children(pid: int) -> list[int]:
    """Return the processes that the process started and that still run."""
    lists = Path(f"/proc/{pid}/task").glob("*/children")
    return [int(child) for file in lists for child in file.read_text().split()]


def descendants(pid: int) -> list[int]:
    """Return the processes that the process and its descendants started."""
    found = children(pid)
    return found + [other for child in found for other in descendants(child)]


def process_of(module: str, pid: int) -> int | None:
    """Return the descendant that runs a module of Python, if there is one."""
    for one in descendants(pid):
        words = Path(f"/proc/{one}/cmdline").read_bytes().split(b"\0")
        if words[1:3] == [b"-m", module.encode()]:
            return one
    return None


def listening(pid: int) -> dict[str, set[str]]:
    """Return where the process can be reached: protocol → hexadecimal addresses."""
    links = []
    for link in Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(FileNotFoundError):  # closed meanwhile
            links.append(str(link.readlink()))
    inodes = {link[8:-1] for link in links if link.startswith("socket:[")}
    found: dict[str, set[str]] = {}
    for protocol in ("tcp", "tcp6", "udp", "udp6"):
        rows = Path(f"/proc/{pid}/net/{protocol}").read_text().splitlines()[1:]
        for local, state, inode in ((r[1], r[3], r[9]) for r in map(str.split, rows)):
            if inode in inodes and (state == _LISTENING or protocol.startswith("udp")):
                found.setdefault(protocol, set()).add(local.partition(":")[0])
    return found
