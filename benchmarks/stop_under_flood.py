"""Measures the delay of an emergency stop while other clients flood the robot.

The robot, the flooding clients and the stopping client run in separate processes.
Rounds with floods and rounds without floods alternate, so that each ratio compares
measurements under the same conditions.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import socket
import statistics
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen
from typing import Final

sys.path.insert(0, str(Path(__file__).parent.parent))

from benchmarks.flooding_client import KINDS, RTDE_KINDS, connected, framed
from tool0.installation.ros2.installation import find_ros2

CLIENT = Path(__file__).with_name("flooding_client.py")
ROS2_CLIENT = Path(__file__).with_name("ros2_client.py")
N_STOPS = 60
"""Number of stops in one round."""
ROUNDS = 4
PAUSE = 0.01
"""Longest pause between two stops [wall s]."""
SETTLE = 1.0
"""Time from the start of a flood to the first stop that is measured, and from the end
of a flood to the next round [wall s]."""
TIMEOUT = 60.0
"""Longest wait for a reply [wall s]."""
COUNTS = (4, 20)
"""Numbers of flooding clients."""
UR_COUNTS = (4, 16)
"""Numbers of flooding clients of a UR.  A port of a UR accepts no more clients."""
SOCKET, PAGE = "socket", "WebSocket"
DASHBOARD_PORT = 29999
UR_HOST = "127.19.29.40"
ROS2_DOMAIN = 98

Command = tuple[Sequence[str], Mapping[str, str] | None]
"""Command of a flooding client, and its environment variables if they differ."""


@dataclass(frozen=True)
class Robot:
    """A bring-up in a separate process."""

    socket: str
    """Path of the bring-up's Unix socket."""
    page: str
    """Address of the bring-up's panel."""

    def address(self, transport: str) -> str:
        """Return the address to which clients connect."""
        return self.socket if transport == SOCKET else self.page


@dataclass(frozen=True)
class Delays:
    """Time from sending a stop until its reply is received [wall s]."""

    p50: float
    p99: float

    @staticmethod
    def of(samples: Sequence[float]) -> Delays:
        """Return the quantiles of samples."""
        return Delays(
            p50=statistics.median(samples),
            p99=statistics.quantiles(samples, n=100, method="inclusive")[98],
        )

    def over(self, other: Delays) -> Delays:
        """Return the ratios to other delays."""
        return Delays(p50=self.p50 / other.p50, p99=self.p99 / other.p99)


class Stopper:
    """A client that only presses and releases the emergency stop."""

    def __init__(self, address: str) -> None:
        self._address = address
        self._peer = connected(address)
        self._peer.settimeout(TIMEOUT)
        self._answers = self._messages()
        assert next(self._answers)["type"] == "hello"

    def press(self) -> float:
        """Stop and release.  Return the delay of the reply to the stop [wall s]."""
        start = time.perf_counter()
        self._ask(engaged=True)
        delay = time.perf_counter() - start
        self._ask(engaged=False)
        return delay

    def close(self) -> None:
        self._peer.close()

    def _ask(self, *, engaged: bool) -> None:
        request = {"id": 7, "method": "emergency_stop", "params": {"engaged": engaged}}
        self._peer.sendall(framed(self._address, json.dumps(request).encode()))
        while (answer := next(self._answers))["type"] != "reply":
            pass
        assert answer["id"] == 7, answer
        assert "error" not in answer, answer

    def _messages(self) -> Iterator[dict[str, object]]:
        stream = self._peer.makefile("rb")
        if not self._address.startswith("http://"):
            for line in stream:
                yield json.loads(line)
        while header := stream.read(2):
            size = header[1]
            if size == 126:
                (size,) = struct.unpack(">H", stream.read(2))
            elif size == 127:
                (size,) = struct.unpack(">Q", stream.read(8))
            payload = stream.read(size)
            if header[0] & 0x0F == 1:  # the message is not a ping
                yield json.loads(payload)


class DashboardStopper:
    """A client of a UR's dashboard server that stops the program."""

    def __init__(self, host: str) -> None:
        deadline = time.monotonic() + TIMEOUT
        while True:
            try:
                self._peer = socket.create_connection((host, DASHBOARD_PORT), TIMEOUT)
                break
            except ConnectionRefusedError:  # the server is still starting
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.1)
        self._lines = self._peer.makefile("rb")
        self._lines.readline()

    def press(self) -> float:
        """Stop, and return the delay of the answer [wall s]."""
        start = time.perf_counter()
        self._peer.sendall(b"stop\n")
        assert self._lines.readline() == b"Stopped\n"
        return time.perf_counter() - start

    def close(self) -> None:
        self._peer.close()


def clients(
    address: str, count: int, kinds: Sequence[str] = tuple(KINDS)
) -> list[Command]:
    """Return clients that send messages of all kinds to one address."""
    script = (sys.executable, "-S", str(CLIENT))
    return [((*script, kinds[k % len(kinds)], address), None) for k in range(count)]


def over_own_transport(transport: str) -> dict[str, Delays]:
    """Measure stops while clients flood the same transport.

    The result contains the ratios by number of clients.
    """
    with bringup() as robot:
        address = robot.address(transport)
        loads = {str(n): clients(address, n) for n in COUNTS}
        return ratios(Stopper(address), loads)


def over_ur(name: str) -> dict[str, Delays]:
    """Measure a UR's ``stop`` or emergency stops while clients flood RTDE.

    Args:
        name: Interface of the client that stops: ``dashboard`` or ``socket``.
    """
    with bringup("--arm", "ur5e", "--ur", "--ur-host", UR_HOST) as robot:
        address, kinds = f"rtde://{UR_HOST}", tuple(RTDE_KINDS)
        loads = {str(n): clients(address, n, kinds) for n in UR_COUNTS}
        is_own = name == "dashboard"
        stopper = DashboardStopper(UR_HOST) if is_own else Stopper(robot.socket)
        return ratios(stopper, loads)


def over_ros2() -> dict[str, Delays]:
    """Measure emergency stops by socket while ROS 2 is flooded.

    The result contains the ratios by the kind of flood.
    """
    ros2 = find_ros2()
    assert ros2 is not None
    settings = {
        "ROS_DOMAIN_ID": str(ROS2_DOMAIN),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    environment = {**ros2.environment, **settings}
    script = (str(ros2.python), str(ROS2_CLIENT))
    with bringup("--arm", "ur5e", "--ros2", environment=settings) as robot:
        loads: dict[str, list[Command]] = {
            role: [((*script, f"flood_{role}"), environment)] * 2
            for role in ("topic", "service")
        }
        return ratios(Stopper(robot.socket), loads)


def ratios(
    stopper: Stopper | DashboardStopper, loads: Mapping[str, Sequence[Command]]
) -> dict[str, Delays]:
    """Return the delays with each load, divided by the delays without a load.

    The delays with and without a load are measured in the same minutes.
    """
    alone: list[float] = []
    flooded: dict[str, list[float]] = {name: [] for name in loads}
    stopper.press()
    for _ in range(ROUNDS):
        for name, load in loads.items():
            alone += _presses(stopper)
            with flooding(load):
                time.sleep(SETTLE)
                flooded[name] += _presses(stopper)
            time.sleep(SETTLE)
    stopper.close()
    without = Delays.of(alone)
    p50, p99 = 1e3 * without.p50, 1e3 * without.p99
    print(f"without a flood: p50 {p50:.2f} ms, p99 {p99:.2f} ms", flush=True)
    return {name: Delays.of(some).over(without) for name, some in flooded.items()}


def _presses(stopper: Stopper | DashboardStopper) -> list[float]:
    delays = []
    for _ in range(N_STOPS):
        # prevents synchronization with the server
        time.sleep(random.uniform(0.0, PAUSE))
        delays.append(stopper.press())
    return delays


@contextlib.contextmanager
def flooding(load: Sequence[Command]) -> Iterator[None]:
    """Run flooding clients in this context, each in a separate process."""
    processes = [
        Popen(command, stdout=PIPE, text=True, env=environment)
        for command, environment in load
    ]
    try:
        for process in processes:
            assert process.stdout is not None
            assert process.stdout.readline() == "floods\n"
        yield
    finally:
        for process in processes:
            process.kill()
            process.communicate()


@contextlib.contextmanager
def bringup(
    *options: str, environment: Mapping[str, str] | None = None
) -> Iterator[Robot]:
    """Run a bring-up with its panel in real time."""
    name = f"benchmark-stop-{os.getpid()}"
    command = [sys.executable, "-m", "tool0", "bringup", "--name", name, "--no-open"]
    command += ["--panel-port", "0", *options]
    with (
        tempfile.TemporaryDirectory() as folder,
        Popen(
            command,
            stdout=PIPE,
            stderr=DEVNULL,
            text=True,
            env={**os.environ, "XDG_RUNTIME_DIR": folder, **(environment or {})},
        ) as program,
    ):
        try:
            assert program.stdout is not None
            lines = iter(program.stdout.readline, "")
            url = next(line.split()[1] for line in lines if line.startswith("Panel: "))
            path = Path(folder) / "tool0" / f"{name}.sock"
            yield Robot(socket=str(path), page=url)
        finally:
            program.send_signal(signal.SIGINT)
            program.communicate()


MEASURED: Final[Mapping[str, Callable[[], dict[str, Delays]]]] = {
    f"{SOCKET}, flooding sockets": partial(over_own_transport, SOCKET),
    f"{PAGE}, flooding pages": partial(over_own_transport, PAGE),
    "UR's dashboard, RTDE flood": partial(over_ur, "dashboard"),
    "socket, RTDE flood": partial(over_ur, "socket"),
    "socket, ROS 2 flood": over_ros2,
}
"""Functions that measure stops, by the stopping client and the kind of flood."""


if __name__ == "__main__":
    for title, measure in MEASURED.items():
        if not all(word in title for word in sys.argv[1:]):
            continue
        for load, delays in measure().items():
            ratios_text = f"p50 x {delays.p50:.2f}, p99 x {delays.p99:.2f}"
            print(f"{title}, {load}: {ratios_text}", flush=True)
