"""How long the reply to an emergency stop takes while other clients flood the robot.

The robot, the flooding clients and the one that stops are processes of their own.
Rounds with and without floods alternate, so that the ratios are of the same machine.
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
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen

sys.path.insert(0, str(Path(__file__).parent.parent))

from benchmarks.flooding_client import KINDS, RTDE_KINDS, connected, framed

CLIENT = Path(__file__).with_name("flooding_client.py")
N_STOPS = 60
"""Of one round."""
ROUNDS = 4
PAUSE = 0.01
"""Longest one between two stops [wall s]."""
SETTLE = 1.0
"""From the start of a flood to the first stop that counts [wall s]."""
SOCKET, PAGE = "socket", "WebSocket"
UR_HOST = "127.19.29.40"


@dataclass(frozen=True)
class Robot:
    """A bring-up in a process of its own."""

    socket: str
    """Path of its Unix socket."""
    page: str
    """Address of its panel."""

    def address(self, transport: str) -> str:
        """Return where clients connect."""
        return self.socket if transport == SOCKET else self.page


@dataclass(frozen=True)
class Delays:
    """From before a stop is sent until its reply has arrived [wall s]."""

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
        """Return the ratios to another's."""
        return Delays(p50=self.p50 / other.p50, p99=self.p99 / other.p99)


class Stopper:
    """A client that presses and releases the emergency stop, and does nothing else."""

    def __init__(self, address: str) -> None:
        self._address = address
        self._peer = connected(address)
        self._answers = self._messages()
        assert next(self._answers)["type"] == "hello"

    def press(self) -> float:
        """Stop, and release; return how long the reply to the stop took [wall s]."""
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
            if header[0] & 0x0F == 1:  # not a ping
                yield json.loads(payload)


def ratios(
    transport: str,
    loads: Sequence[Sequence[tuple[str, str]]],
    robot: Robot,
    *,
    rounds: int = ROUNDS,
    n_stops: int = N_STOPS,
) -> tuple[Delays, list[Delays]]:
    """Return the delays without a flood, and for each load its delays ÷ those.

    Args:
        transport: Of the client that stops.
        loads: Of each load the flooding clients: what they send, and where.
        robot: The bring-up.
        rounds: Of each load.
        n_stops: In each round.
    """
    stopper = Stopper(robot.address(transport))
    alone: list[float] = []
    flooded: list[list[float]] = [[] for _ in loads]
    stopper.press()
    for _ in range(rounds):
        for load, samples in zip(loads, flooded, strict=True):
            alone += _presses(stopper, n_stops)
            with flooding(load):
                time.sleep(SETTLE)
                samples += _presses(stopper, n_stops)
            time.sleep(SETTLE)
    stopper.close()
    without = Delays.of(alone)
    return without, [Delays.of(samples).over(without) for samples in flooded]


def _presses(stopper: Stopper, count: int) -> list[float]:
    delays = []
    for _ in range(count):
        time.sleep(random.uniform(0.0, PAUSE))  # not in step with the server
        delays.append(stopper.press())
    return delays


@contextlib.contextmanager
def flooding(clients: Sequence[tuple[str, str]]) -> Iterator[None]:
    """Let clients flood until the end, each in a process of its own."""
    processes = [
        Popen([sys.executable, "-S", str(CLIENT), *words], stdout=PIPE, text=True)
        for words in clients
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
def bringup(*options: str) -> Iterator[Robot]:
    """Run a bring-up with its panel, in real time."""
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
            env={**os.environ, "XDG_RUNTIME_DIR": folder},
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


def mixed(robot: Robot, transport: str, count: int) -> list[tuple[str, str]]:
    """Return clients that send something of every kind over one transport."""
    kinds = list(KINDS)
    address = robot.address(transport)
    return [(kinds[k % len(kinds)], address) for k in range(count)]


def alike(robot: Robot, transport: str, kind: str, count: int) -> list[tuple[str, str]]:
    return [(kind, robot.address(transport))] * count


if __name__ == "__main__":
    counts = [int(word) for word in sys.argv[2:]] or [4, 20]
    wanted = sys.argv[1] if len(sys.argv) > 1 else "mixed"
    with bringup() as robot:
        for transport in (SOCKET, PAGE):
            for kind in KINDS if wanted == "each" else [wanted]:
                loads = [
                    mixed(robot, transport, n) if kind == "mixed"
                    else alike(robot, transport, kind, n) for n in counts]
                without, found = ratios(transport, loads, robot, rounds=1)
                print(f"{transport}, {kind}: alone p50 {1e3*without.p50:.2f} p99 {1e3 * without.p99:.2f} ms", flush=True)
                for n, r in zip(counts, found):
                    print(f"   {n}: p50 x{r.p50:.1f} p99 x{r.p99:.1f}", flush=True)
