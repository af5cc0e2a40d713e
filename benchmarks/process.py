"""Measures start-up times, compared with ``import mujoco``, and memory."""

from __future__ import annotations

import os
import statistics
import sys
import time
from dataclasses import dataclass
from subprocess import DEVNULL, Popen, check_output

ROUNDS = 9
BRINGUP = [
    *(sys.executable, "-m", "tool0", "bringup", "--headless", "--duration", "0"),
    *("--no-realtime", "--no-summary", "--name", "benchmark"),
]
IMPORT = [sys.executable, "-c", "import mujoco"]
IMPORT_TOOL0 = [sys.executable, "-c", "import tool0"]


@dataclass(frozen=True)
class Cost:
    """Cost of one process, from its start to its end."""

    seconds: float
    megabytes: float
    """Largest resident memory [MB]."""


def cost(command: list[str]) -> Cost:
    """Run ``command`` to its end, and return its cost."""
    start = time.perf_counter()
    with Popen(command, stdout=DEVNULL) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} ended with {process.returncode}")
    return Cost(time.perf_counter() - start, usage.ru_maxrss / 1024)


def start_ratio() -> float:
    """Return the time of a bring-up divided by the time of ``import mujoco``.

    The bring-up ends as soon as all controllers run.
    """
    cost(BRINGUP)  # compiles the bytecode
    pairs = [(cost(BRINGUP), cost(IMPORT)) for _ in range(ROUNDS)]
    return statistics.median(ours.seconds / bare.seconds for ours, bare in pairs)


def import_ratio() -> float:
    """Return the time of ``import tool0`` divided by that of ``import mujoco``.

    The times of both imports include the start of Python.
    """
    pairs = [(cost(IMPORT_TOOL0), cost(IMPORT)) for _ in range(ROUNDS)]
    return statistics.median(ours.seconds / bare.seconds for ours, bare in pairs)


def memory() -> float:
    """Return the resident memory of a headless run of ten seconds [MB].

    A small process starts the run, because Linux also counts the memory of the starting
    process.
    """
    return float(check_output([sys.executable, "-I", __file__], text=True))


if __name__ == "__main__":
    command = [*BRINGUP]
    command[command.index("0")] = "10"
    print(cost(command).megabytes)
