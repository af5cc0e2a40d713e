"""Measures the costs of ROS 2: age of joint states, speed, latency and start-up.

The robot runs in this process, and the node and an rclpy client run in other processes.
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
from subprocess import DEVNULL, PIPE, Popen

import tool0
from tool0.installation.ros2.installation import NODE_FOLDER, Ros2, find_ros2
from tool0.protocol.address import Claim
from tool0.protocol.channel import backend_of
from tool0.server.server import Server, UnixSocketService

NAME = f"benchmark-ros2-{os.getpid()}"
DOMAIN = 97
ARM = "ur5e"
RATE = 500.0  # rate of the robot's updates [Hz]
N_STATES = 5000
N_COMMANDS = 200
JOINT = "shoulder_pan_joint"
JUMP = 0.5
"""Smallest change of effort within a tick that only a command causes [N·m]."""
PAUSE = 0.1
"""Time between two commands, the same as in ``ros2_client.py`` [wall s]."""
ROUNDS = 5
SECONDS = 2.0
"""Duration of one measurement of speed [wall s]."""
CONTROLLERS = ("joint_state_broadcaster", "joint_trajectory_controller")
CLIENT = Path(__file__).with_name("ros2_client.py")


@dataclass(frozen=True)
class States:
    """Messages of /joint_states at one subscriber."""

    rate: float
    """Mean rate of the messages in wall time [Hz]."""
    p50: float
    """Median age at reception, from the end of the tick [s]."""
    p99: float


@dataclass(frozen=True)
class Latency:
    """Latency from calling ``publish`` in a client to the effort of the joint [s]."""

    p50: float
    p99: float


def joint_states() -> States:
    """Measure the rate and the age of joint states while the robot is at rest."""
    with _robot(realtime=True) as robot:
        published: list[tuple[float, float]] = []
        simulation = robot.simulation

        def note() -> None:
            published.append((simulation.snapshot.time, time.monotonic()))

        subscription = simulation.subscribe(RATE, when_published=note)
        with _node(), _client("states", str(N_STATES)) as client:
            received = json.loads(client.communicate()[0])
        subscription.close()
    times = [simulated for simulated, _ in published]
    ages = []
    for stamp, arrival in received:
        k = bisect.bisect_left(times, stamp - 1e-6)
        ages.append(arrival - published[k][1])
    elapsed = received[-1][1] - received[0][1]
    return States(
        rate=(len(received) - 1) / elapsed,
        p50=statistics.median(ages),
        p99=statistics.quantiles(ages, n=100)[98],
    )


def latency() -> Latency:
    """Measure the latency like ``benchmarks/ros1.py`` does."""
    with _robot(realtime=True) as robot:
        index = robot.snapshot.joint_names.index(JOINT)
        jumps: list[float] = []
        write, last = robot.engine.write, [0.0]

        def watched(effort: Sequence[float]) -> None:
            if abs(effort[index] - last[0]) > JUMP:
                jumps.append(time.monotonic())
            last[0] = effort[index]
            write(effort)

        robot.engine.write = watched  # type: ignore[method-assign]
        with _node(), _client("commands", str(N_COMMANDS)) as client:
            sent = json.loads(client.communicate()[0])
    delays = []
    for start in sent:
        k = bisect.bisect(jumps, start)
        if k < len(jumps) and jumps[k] - start < PAUSE:
            delays.append(jumps[k] - start)
    if len(delays) < 0.9 * len(sent):
        raise RuntimeError(f"only {len(delays)} of {len(sent)} commands had an effect")
    return Latency(
        p50=statistics.median(delays), p99=statistics.quantiles(delays, n=100)[98]
    )


def speed_ratio(*, realtime: bool) -> float:
    """Return the simulation speed with the node divided by that without the node.

    The speed is simulated time per wall time.

    In real time, late ticks would lower the ratio.  If it is not in real time, the
    simulation runs as fast as possible.  Rounds with the node and without the node
    alternate, and the result is the median of the ratios.
    """
    with _robot(realtime=realtime) as robot:
        ratios = []
        for _ in range(ROUNDS):
            without = _speed(robot)
            with _node():
                ratios.append(_speed(robot) / without)
    return statistics.median(ratios)


def start_seconds() -> float:
    """Return the time from ``bringup --ros2`` until all controllers are active [s].

    A client that is already running measures the time.
    """
    with _client("active", *CONTROLLERS) as client:
        assert client.stdout is not None
        assert client.stdout.readline() == "ready\n"
        start = time.monotonic()
        command = [
            *(sys.executable, "-m", "tool0", "bringup", "--headless", "--ros2"),
            *("--arm", ARM, "--name", NAME),
        ]
        with Popen(command, env=_environment(), stdout=DEVNULL) as bringup:
            try:
                return float(json.loads(client.communicate()[0])) - start
            finally:
                bringup.terminate()


@contextlib.contextmanager
def _robot(*, realtime: bool) -> Iterator[tool0.Robot]:
    """Bring up a robot to which other processes can connect."""
    with tool0.bringup(arm=ARM, ros2_control=True, realtime=realtime) as robot:
        service = UnixSocketService(Claim(NAME))
        with Server(backend_of(robot.channel), [service], NAME):
            yield robot


def _speed(robot: tool0.Robot) -> float:
    """Return simulated seconds per wall second."""
    start, before = time.monotonic(), robot.time
    while time.monotonic() < start + SECONDS:
        robot.run(0.1)
    return (robot.time - before) / (time.monotonic() - start)


@contextlib.contextmanager
def _node() -> Iterator[None]:
    """Run the node of the robot in ROS 2."""
    environment = _environment() | {"PYTHONPATH": str(NODE_FOLDER)}
    command = [str(_ros2().python), "-m", "tool0_ros2", "--name", NAME]
    with Popen(command, env=environment, stdout=PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            if "ready" not in process.stdout.readline():
                raise RuntimeError("the node did not start")
            yield
        finally:
            process.terminate()


@contextlib.contextmanager
def _client(*arguments: str) -> Iterator[Popen[str]]:
    command = [str(_ros2().python), str(CLIENT), *arguments]
    with Popen(command, env=_environment(), stdout=PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def _ros2() -> Ros2:
    found = find_ros2()
    if found is None:
        raise RuntimeError("there is no ROS 2 here")
    return found


def _environment() -> dict[str, str]:
    return {
        **_ros2().environment,
        "ROS_DOMAIN_ID": str(DOMAIN),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }


if __name__ == "__main__":
    print(joint_states())
    print(latency())
    for is_real in (True, False):
        print(f"steps/s ÷ without, realtime={is_real}:", speed_ratio(realtime=is_real))
    print("start [s]:", start_seconds())
