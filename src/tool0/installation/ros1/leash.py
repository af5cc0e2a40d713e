"""Runs a program that ends with whoever started it: ``leash.py PROGRAM ARGUMENT…``.

Standard input is a pipe that only who started us holds open, so that its end tells of
theirs, however it came about.  Run as a script; it imports nothing of tool0.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading

PATIENCE = 5.0
"""[s] that the program has to end by itself."""


def main(command: list[str]) -> int:
    """Run ``command`` until it ends or we are let go of; return its exit status."""
    try:
        program = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, start_new_session=True
        )
    except OSError as error:
        print(error, file=sys.stderr)
        return 127
    threading.Thread(target=_end_with_us, args=(program.pid,), daemon=True).start()
    status = program.wait()
    _signal(program.pid, signal.SIGKILL)  # whom it left behind
    return status & 0xFF


def _end_with_us(group: int) -> None:
    os.read(0, 1)  # nobody writes: it returns at the end
    _signal(group, signal.SIGINT)
    threading.Event().wait(PATIENCE)
    _signal(group, signal.SIGKILL)


def _signal(group: int, number: signal.Signals) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, number)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
