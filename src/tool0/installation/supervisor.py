"""Ends a process group when its parent ends; the counterpart of ``child_process``.

Run as a script, in a Python without site-packages, it starts the program that a line of
JSON on standard input describes, and answers with its process id, then ``0`` if it
cannot be executed.  Standard input is a socket: when its other end closes, for whatever
reason, the group is ended.
Nothing of tool0 is imported here.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable
from typing import NoReturn


def main() -> NoReturn:
    """Start the program that standard input describes, and supervise it."""
    import json
    import subprocess
    import sys

    with open(0, "rb", closefd=False) as stream:
        request = json.loads(stream.readline() or "null")
    if request is None:  # the parent has ended already
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
            # It says its id itself: once it runs, we may be killed at any moment.
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
    """Wait for a process group's leader, end the group, and exit like the leader.

    Args:
        group: The process group, by the id of its leader.
        connection: File descriptor; when its other end closes, the group is ended.
        wait: Returns the exit status of the leader, negative for a signal.
        grace: Time between SIGINT and SIGKILL [wall s]; 0 for SIGKILL at once.
    """
    threading.Thread(
        target=_end_with_parent, args=(group, connection, grace), daemon=True
    ).start()
    status = wait()
    _signal_group(group, signal.SIGKILL)  # what the leader left behind
    if status < 0:
        _die_by(-status)
    os._exit(status)


def _end_with_parent(group: int, connection: int, grace: float) -> None:
    with contextlib.suppress(OSError):  # reset, if the parent did not read our answer
        while os.read(connection, 1):
            pass
    if grace > 0.0:
        _signal_group(group, signal.SIGINT)
        threading.Event().wait(grace)
    _signal_group(group, signal.SIGKILL)


def _signal_group(group: int, number: int) -> None:
    # macOS refuses, where others do not find, a group that has ended.
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(group, number)


def _die_by(number: int) -> None:
    """End by this signal, so that the parent sees the program's status."""
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(OSError):  # SIGKILL has no handler
        signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


if __name__ == "__main__":
    main()
