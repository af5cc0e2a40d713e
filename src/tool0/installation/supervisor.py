"""Ends a process group when its parent ends.  ``child_process`` starts this script.

This file is run as a script, in a Python without site-packages.  The script reads one
line of JSON from standard input, and starts the program that the line describes.  The
script answers with the program's process ID, followed by ``0`` if the program cannot be
executed.  Standard input is a socket.  When the other end of the socket closes for any
reason, the process group is ended.  This file imports nothing from tool0.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable
from typing import NoReturn


def main() -> NoReturn:
    """Start the program that standard input describes, and supervise the program."""
    import json
    import subprocess
    import sys

    with open(0, "rb", closefd=False) as stream:
        request = json.loads(stream.readline() or "null")
    if request is None:  # the parent has already ended
        os._exit(1)
    answer = os.dup(0)

    def send(text: str) -> None:
        with contextlib.suppress(OSError):
            os.write(answer, text.encode())

    try:
        program = subprocess.Popen(
            request["command"],
            env=request["environment"],
            cwd=request["folder"],
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            # The program sends its own ID, because this process may be killed at any
            # moment after the program starts.
            preexec_fn=lambda: send(f"{os.getpid()} "),  # noqa: PLW1509 - no threads yet
        )
    except OSError as error:
        send("0\n")
        print(error, file=sys.stderr, flush=True)
        os._exit(127)
    send("\n")
    supervise(program.pid, 0, program.wait, request["grace"])


def supervise(
    group: int, connection: int, wait: Callable[[], int], grace: float
) -> NoReturn:
    """Wait for a process group's leader, end the group, and exit as the leader did.

    Args:
        group: The ID of the process group, which is the process ID of its leader.
        connection: File descriptor of the connection to the parent.  When the other end
            of the connection closes, the group is ended.
        wait: Function that returns the exit status of the leader.  The status is
            negative for a signal.
        grace: Time between SIGINT and SIGKILL [wall s].  If the time is 0, SIGKILL is
            sent immediately.
    """
    threading.Thread(
        target=_end_with_parent, args=(group, connection, grace), daemon=True
    ).start()
    status = wait()
    _signal_group(group, signal.SIGKILL)  # processes that the leader started
    if status < 0:
        _die_by(-status)
    os._exit(status)


def _end_with_parent(group: int, connection: int, grace: float) -> None:
    # the connection is reset if the parent did not read our answer
    with contextlib.suppress(OSError):
        while os.read(connection, 1):
            pass
    if grace > 0.0:
        _signal_group(group, signal.SIGINT)
        threading.Event().wait(grace)
    for process in _descendants(group):  # may be in groups of their own, like roscore's
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.kill(process, signal.SIGKILL)
    _signal_group(group, signal.SIGKILL)


def _descendants(process: int) -> list[int]:
    """Return the descendants of a process; on systems other than Linux, none."""
    # Without pathlib, whose import would delay the end.
    found: list[int] = []
    with contextlib.suppress(OSError):  # also if the process has ended
        for thread in os.listdir(f"/proc/{process}/task"):  # noqa: PTH208
            with open(f"/proc/{process}/task/{thread}/children") as file:  # noqa: PTH123
                found += map(int, file.read().split())
    return found + [other for child in found for other in _descendants(child)]


def _signal_group(group: int, number: int) -> None:
    # For a group that has ended, macOS raises PermissionError, and other systems raise
    # ProcessLookupError.
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(group, number)


def _die_by(number: int) -> None:
    """End this process with a signal, so that the parent sees the program's status."""
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(OSError):  # SIGKILL cannot have a handler
        signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


if __name__ == "__main__":
    main()
