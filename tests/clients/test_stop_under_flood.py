"""An emergency stop while other programs send as fast as they can."""

from __future__ import annotations

import contextlib
import json
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from page import TIMEOUT, socket_url
from served import serving, use_folder
from websockets.sync.client import connect

import tool0
from tool0.panel.server import Panel

FLOOD = Path(__file__).parents[2] / "benchmarks" / "flooding_client.py"
N_STOPS = 15
MOST = 20.0
"""Times longer than without a flood, medians: a neighbour on the machine must not fail
this test, and what waits behind a flood takes hundreds of times longer."""

Press = Callable[[], None]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


def requests() -> Iterator[str]:
    for engaged in (True, False):
        params = {"engaged": engaged}
        yield json.dumps({"id": 7, "method": "emergency_stop", "params": params})


@contextlib.contextmanager
def program(address: str) -> Iterator[Press]:
    """Return what stops over the Unix socket, and releases the stop."""
    peer = socket.socket(socket.AF_UNIX)
    peer.settimeout(TIMEOUT)
    peer.connect(address)
    with peer, peer.makefile("rb") as lines:
        lines.readline()  # hello

        def press() -> None:
            for request in requests():
                peer.sendall(request.encode() + b"\n")
                assert "error" not in json.loads(lines.readline())

        yield press


@contextlib.contextmanager
def page(address: str) -> Iterator[Press]:
    """Return what stops over the WebSocket, and releases the stop."""
    with connect(socket_url(address), open_timeout=TIMEOUT) as peer:
        peer.recv(TIMEOUT)  # hello

        def press() -> None:
            for request in requests():
                peer.send(request)
                assert "error" not in json.loads(peer.recv(TIMEOUT))

        yield press


def median(press: Press) -> float:
    """Return the median duration of presses [wall s]."""
    durations = []
    for _ in range(N_STOPS):
        start = time.perf_counter()
        press()
        durations.append(time.perf_counter() - start)
    return statistics.median(durations)


@contextlib.contextmanager
def flooding(kinds: list[str], address: str) -> Iterator[None]:
    clients = [
        subprocess.Popen(
            [sys.executable, "-S", FLOOD, kind, address],
            stdout=subprocess.PIPE,
            text=True,
        )
        for kind in kinds
    ]
    try:
        for client in clients:
            assert client.stdout is not None
            assert client.stdout.readline() == "floods\n"
        yield
    finally:
        for client in clients:
            client.kill()
            client.communicate()


@pytest.mark.parametrize("client", [program, page])
def test_floods_hardly_delay_a_stop(
    client: Callable[[str], contextlib.AbstractContextManager[Press]], folder: Path
) -> None:
    kinds = ["unknown", "valid", "garbage", "unknown"]
    with tool0.bringup(realtime=True) as robot, serving(robot), Panel(robot) as panel:
        address = str(folder / "tool0.sock") if client is program else panel.url
        with client(address) as press:
            press()
            alone = median(press)
            with flooding(kinds, address):
                flooded = median(press)
            alone = max(alone, median(press))
    assert flooded < MOST * alone
