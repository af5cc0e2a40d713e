"""Thousands of connections that only take up room, and peers that never read."""

from __future__ import annotations

import contextlib
import json
import resource
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from page import TIMEOUT, page_at, socket_url
from served import use_folder
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

import tool0
from tool0.cli import OK, main
from tool0.panel.server import Panel

N_DESCRIPTORS = 200
"""That the bring-up may have."""
N_IDLE = 600


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


@pytest.fixture
def sockets() -> Iterator[list[socket.socket]]:
    """Sockets that are closed in the end; this process may have enough of them."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = N_IDLE + 500
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    opened: list[socket.socket] = []
    yield opened
    for item in opened:
        item.close()
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.fixture
def bringup() -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run a bring-up with few descriptors, whose panel other machines reach."""
    command = f'ulimit -n {N_DESCRIPTORS}; exec "$@"'
    options = ["--panel-host", "0.0.0.0", "--panel-port", "0", "--no-open"]
    with subprocess.Popen(
        ["sh", "-c", command, "sh", sys.executable, "-m", "tool0", "bringup", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdout is not None
        lines = iter(program.stdout.readline, "")
        url = next(line.split()[1] for line in lines if line.startswith("Panel: "))
        name = urlsplit(url).hostname
        assert name is not None
        yield program, url.replace(name, "127.0.0.1")
        program.kill()


@contextlib.contextmanager
def silent_page(url: str) -> Iterator[ClientConnection]:
    """Connect as a page that subscribes to nothing: it may read as late as it likes."""
    with connect(socket_url(url), open_timeout=TIMEOUT) as page:
        assert json.loads(page.recv(TIMEOUT))["type"] == "hello"
        yield page


def release(page: ClientConnection) -> None:
    """Release the emergency stop from ``page``, which the server still has to serve."""
    params = {"engaged": False}
    page.send(json.dumps({"id": 1, "method": "emergency_stop", "params": params}))
    assert json.loads(page.recv(TIMEOUT))["id"] == 1


def open_idle(url: str, beginning: bytes) -> socket.socket:
    parts = urlsplit(url)
    idle = socket.create_connection((parts.hostname, parts.port), TIMEOUT)
    with contextlib.suppress(OSError):  # it may have been dropped already
        idle.sendall(beginning)
    return idle


def subscribe_without_reading(folder: Path) -> socket.socket:
    program = socket.socket(socket.AF_UNIX)
    program.connect(str(folder / "tool0.sock"))
    request = {"method": "subscribe", "params": {"rate": 500.0}}
    program.sendall(json.dumps(request).encode() + b"\n")
    return program


def test_idle_connections_and_slow_readers_delay_nobody(
    bringup: tuple[subprocess.Popen[str], str],
    sockets: list[socket.socket],
    folder: Path,
) -> None:
    program, url = bringup
    with silent_page(url) as old:
        for _ in range(20):
            sockets.append(subscribe_without_reading(folder))
        for k in range(N_IDLE):
            beginning = b"GET / HTTP/1.1\r\nHost: 127" if k % 2 else b""
            sockets.append(open_idle(url, beginning))
        assert main(["estop"]) == OK
        with page_at(url) as new:
            new.wait_for("status", lambda status: status["stopped"])
            release(old)
            new.wait_for("status", lambda status: not status["stopped"])
    n_open = len(list(Path(f"/proc/{program.pid}/fd").iterdir()))
    assert n_open < N_DESCRIPTORS - 30
    program.terminate()
    _, error = program.communicate(timeout=TIMEOUT)
    assert program.returncode == OK
    assert "accept" not in error
    assert len(error) < 2000, error


@pytest.mark.parametrize(
    "beginning",
    [
        b"",
        b"GET / HT",
        b"GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 9\r\n\r\n",
    ],
)
def test_a_connection_that_requests_nothing_is_dropped(
    robot: tool0.Robot,
    monkeypatch: pytest.MonkeyPatch,
    sockets: list[socket.socket],
    beginning: bytes,
) -> None:
    monkeypatch.setattr("tool0.panel.connection_limits.IDLE_AFTER", 0.2)
    with Panel(robot) as panel, page_at(panel.url) as page:
        idle = open_idle(panel.url, beginning)
        sockets.append(idle)
        with contextlib.suppress(ConnectionResetError):
            while idle.recv(4096):
                pass
        assert page.request("pause") is None


def test_a_stranger_makes_room_and_a_page_never_does(
    robot: tool0.Robot,
    monkeypatch: pytest.MonkeyPatch,
    sockets: list[socket.socket],
) -> None:
    monkeypatch.setattr("tool0.panel.connection_limits.MAX_CONNECTIONS", 2)
    with Panel(robot) as panel, silent_page(panel.url) as page:
        stranger = open_idle(panel.url, b"")
        sockets.append(stranger)
        with silent_page(panel.url) as other:
            with contextlib.suppress(ConnectionResetError):
                assert stranger.recv(1) == b""
            with pytest.raises((OSError, WebSocketException)):
                connect(socket_url(panel.url), open_timeout=TIMEOUT)
            release(other)
        release(page)
