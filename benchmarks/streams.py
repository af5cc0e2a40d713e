"""Measures how subscribers in other processes slow the tick."""

from __future__ import annotations

import contextlib
import os
import statistics
import sys
import threading
import time
from collections.abc import Iterator
from subprocess import PIPE, Popen

import tool0
from tool0.protocol.address import Claim
from tool0.protocol.channel import backend_of
from tool0.server.server import Server, UnixSocketService

NAME = f"benchmark-streams-{os.getpid()}"
SECONDS = 2.0
ROUNDS = 5
READER = """
import sys, tool0
with tool0.connect(sys.argv[1]) as robot:
    stream = robot.subscribe(float(sys.argv[2]))
    stream.following(30.0)
    print("reads", flush=True)
    while stream.following(30.0) is not None:
        pass
"""


def tick_cost_ratio(readers: int, rate: float) -> float:
    """Return the ratio of the tick's CPU time with ``readers`` and without readers.

    The times are measured in real time, per simulated second.  Rounds with readers and
    rounds without readers alternate, and the result is the median of the ratios.

    Args:
        readers: Number of processes that read every snapshot.
        rate: Rate at which each process gets snapshots, in simulated time [Hz].
    """
    service = UnixSocketService(Claim(NAME))
    with (
        tool0.bringup() as robot,
        Server(backend_of(robot.channel), [service], NAME),
    ):
        ratios = []
        for _ in range(ROUNDS):
            without = _tick_cpu(robot)
            with _reading(readers, rate):
                ratios.append(_tick_cpu(robot) / without)
    return statistics.median(ratios)


def _tick_cpu(robot: tool0.Robot) -> float:
    """Return the CPU time of the tick's thread per simulated second [s]."""
    (thread,) = (t for t in threading.enumerate() if t.name == "tool0 loop")
    assert thread.ident is not None
    clock = time.pthread_getcpuclockid(thread.ident)
    cpu, simulated = time.clock_gettime(clock), robot.time
    robot.run(SECONDS)
    return (time.clock_gettime(clock) - cpu) / (robot.time - simulated)


@contextlib.contextmanager
def _reading(readers: int, rate: float) -> Iterator[None]:
    """Run processes that read until the context ends."""
    command = [sys.executable, "-c", READER, NAME, str(rate)]
    processes = [Popen(command, stdout=PIPE, text=True) for _ in range(readers)]
    try:
        for process in processes:
            assert process.stdout is not None
            assert process.stdout.readline() == "reads\n"
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()
            assert process.stdout is not None
            process.stdout.close()


if __name__ == "__main__":
    for n in (1, 5):
        for hertz in (125.0, 500.0):
            print(f"{n} at {hertz:g} Hz: {tick_cost_ratio(n, hertz):.3f}")
