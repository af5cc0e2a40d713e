"""Measures the costs of the UR interface: sample age, speed, latency, connecting.

The robot runs in this process, and the interface and ur_rtde run in other processes.
Times are read from the monotonic clock, which all processes of a machine share.
"""

from __future__ import annotations

import bisect
import contextlib
import json
import os
import statistics
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from subprocess import PIPE, Popen
from typing import Any

import tool0

HOST = "127.19.29.39"
ARM = "ur5e"
RATE = 500.0  # rate of the robot's updates [Hz]
N_SAMPLES = 5000
LATE = 1e-3
"""Delay after its tick above which a sample is considered late [s]."""
N_TARGETS = 200
JOINT = "wrist_3_joint"
CHANGE = 0.0015
"""Smallest change of effort in a tick that only a new target causes [N·m].  Without a
new target, the change is a tenth of this value."""
LONGEST = 0.05
"""Delay after which a target without effect is an error [s]."""
N_CONNECTIONS = 5
ROUNDS = 5
SECONDS = 2.0
"""Duration of one measurement of speed [wall s]."""
CLIENT = Path(__file__).with_name("ur_client.py")


@dataclass(frozen=True)
class Samples:
    """Output of RTDE at one client."""

    in_time: float
    """Share of the robot's updates that are received at most ``LATE`` after their
    tick."""
    p50: float
    """Median age at reception, from the end of the tick [s]."""
    p99: float


@dataclass(frozen=True)
class Latency:
    """Latency from calling ``servoJ`` in a client to the effort of the joint [s]."""

    p50: float
    p99: float


@dataclass(frozen=True)
class Connecting:
    """Median times until the constructor of a client returns [s]."""

    receive: float
    control: float


def samples() -> Samples:
    """Measure the age of RTDE's samples at 500 Hz while the robot is at rest."""
    with _robot(realtime=True) as robot:
        published: list[tuple[float, float]] = []
        simulation = robot.simulation

        def note() -> None:
            published.append((simulation.snapshot.time, time.monotonic()))

        subscription = simulation.subscribe(RATE, when_published=note)
        with _interface(robot):
            received = _answer("samples", str(N_SAMPLES))
        subscription.close()
    times = [simulated for simulated, _ in published]
    ages = {}
    for stamp, arrival in received:
        k = bisect.bisect_left(times, stamp - 1e-6)
        ages.setdefault(k, arrival - published[k][1])
    first, last = min(ages), max(ages)
    return Samples(
        in_time=sum(age <= LATE for age in ages.values()) / (last - first + 1),
        p50=statistics.median(ages.values()),
        p99=statistics.quantiles(ages.values(), n=100)[98],
    )


def latency() -> Latency:
    """Measure how fast changes in a stream of servoJ targets take effect."""
    with _robot(realtime=True) as robot:
        index = robot.snapshot.joint_names.index(JOINT)
        jumps: list[float] = []
        write, last = robot.engine.write, [0.0]

        def watched(effort: Sequence[float]) -> None:
            if abs(effort[index] - last[0]) > CHANGE:
                jumps.append(time.monotonic())
            last[0] = effort[index]
            write(effort)

        robot.engine.write = watched  # type: ignore[method-assign]
        with _interface(robot):
            sent = _answer("servo", str(N_TARGETS))
    delays = []
    for start in sent:
        k = bisect.bisect(jumps, start)
        if k < len(jumps) and jumps[k] - start < LONGEST:
            delays.append(jumps[k] - start)
    if len(delays) < 0.9 * len(sent):
        raise RuntimeError(f"only {len(delays)} of {len(sent)} targets had an effect")
    return Latency(
        p50=statistics.median(delays), p99=statistics.quantiles(delays, n=100)[98]
    )


def connecting() -> Connecting:
    """Measure how long the clients of ur_rtde take to connect."""
    with _robot(realtime=True) as robot, _interface(robot):
        rows = _answer("connect", str(N_CONNECTIONS))
    receive, control = zip(*rows, strict=True)
    return Connecting(statistics.median(receive), statistics.median(control))


def speed_ratio() -> float:
    """Return the ratio of simulation speeds with and without the interface.

    A client is connected to the interface.  The speed is simulated time per wall time.

    The simulation runs as fast as possible.  Rounds with the interface and rounds
    without the interface alternate, and the result is the median of the ratios.
    """
    with _robot(realtime=False) as robot:
        ratios = []
        for _ in range(ROUNDS):
            without = _speed(robot)
            with _interface(robot), _client("forever") as client:
                assert client.stdout is not None
                client.stdout.readline()  # the client receives
                ratios.append(_speed(robot) / without)
    return statistics.median(ratios)


def _robot(*, realtime: bool) -> tool0.Robot:
    return tool0.bringup(arm=ARM, realtime=realtime)


def _speed(robot: tool0.Robot) -> float:
    """Return simulated seconds per wall second."""
    start, before = time.monotonic(), robot.time
    while time.monotonic() < start + SECONDS:
        robot.run(0.1)
    return (robot.time - before) / (time.monotonic() - start)


@contextlib.contextmanager
def _interface(robot: tool0.Robot) -> Iterator[None]:
    """Present the robot as a UR."""
    with tool0.UrController(robot, tool0.UrOptions(host=HOST)) as controller:
        controller.wait()
        yield


@contextlib.contextmanager
def _client(*arguments: str) -> Iterator[Popen[str]]:
    command = [sys.executable, str(CLIENT), HOST, *arguments]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    with Popen(command, env=environment, stdout=PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def _answer(*arguments: str) -> Any:
    """Return the measurement of a client, which is the last line of its output."""
    with _client(*arguments) as client:
        return json.loads(client.communicate()[0].splitlines()[-1])


if __name__ == "__main__":
    print(connecting())
    print(samples())
    print(latency())
    print("steps/s ÷ without:", speed_ratio())
