"""Malformed frames on the Unix socket and on the WebSocket of a bring-up.

It goes on, answers others, and prints nothing of what it was sent.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

import msgspec
import pytest
from fuzzing import SCALE, changed, made
from page import TIMEOUT, page_at, socket_url
from served import use_folder

import tool0
from tool0.cli import OK
from tool0.protocol.methods import methods
from tool0.protocol.request import plain

N = 400 * SCALE
"""Frames on each of the sockets."""
SEED = 41
MOST_SAID = 20_000
"""What a bring-up may print about all of them: warnings about its robot [bytes]."""
LASTING = {"run", "step"}
"""Requests that take as long as they say."""
ODD = (
    b"",
    b"{}",
    b"[]",
    b"null",
    b"\xff\xfe\x00",
    b"[" * 4000,
    b'{"a":' * 2000,
    b'{"id":' + b"9" * 4000 + b',"method":"read_snapshot"}',
    b'{"id":{},"method":"read_snapshot"}',
    b'{"id":1,"method":"\xc3\x28"}',
    b'{"id":1,"method":"\\ud800"}',
    b'{"id":1,"method":"read_snapshot","params":[]}',
    b'{"id":1,"method":"step","params":{"ticks":1e400}}',
)


class Bringup(NamedTuple):
    process: subprocess.Popen[str]
    url: str
    socket: Path
    said: list[str]
    """The lines of its standard error."""


@pytest.fixture
def bringup(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bringup]:
    folder = use_folder(monkeypatch, tmp_path)
    homes = {n: str(tmp_path / n) for n in ("HOME", "XDG_DATA_HOME", "XDG_STATE_HOME")}
    command = [sys.executable, "-m", "tool0", "bringup", "--no-open"]
    command += ["--panel-port", "0", "--scene", "table_and_cubes"]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env=os.environ | homes,
        cwd=tmp_path,
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        said: list[str] = []
        listener = threading.Thread(target=said.extend, args=(process.stderr,))
        listener.start()
        try:
            url = next(
                word
                for line in process.stdout
                for word in line.split()
                if "http" in word
            )
            rest = threading.Thread(target=process.stdout.read)
            rest.start()
            yield Bringup(process, url, folder / "tool0.sock", said)
        finally:
            process.kill()
            listener.join()


def message(rng: random.Random, kinds: list[tuple[str, Any]]) -> bytes:
    """Return a request in JSON, or what is left of it."""
    if rng.random() < 0.1:
        return rng.choice(ODD)
    method, kind = rng.choice(kinds)
    params: Any = made(kind, rng)
    with contextlib.suppress(ValueError, TypeError, RecursionError):
        params = plain(params)
    try:
        text = msgspec.json.encode({"id": 1, "method": method, "params": params})
    except (ValueError, TypeError, OverflowError, UnicodeError):
        text = json.dumps({"id": 1, "method": method, "params": repr(params)}).encode()
    return changed(text, rng) if rng.random() < 0.6 else text


def check(bringup: Bringup, answers: list[bytes]) -> None:
    """Others are answered, and no request failed in a way that nobody expected."""
    unexpected = [answer for answer in answers if b"InternalError" in answer]
    assert not unexpected, unexpected[:3]
    assert bringup.process.poll() is None
    with tool0.connect() as robot:
        robot.emergency_stop(engaged=False)
        robot.resume()
        robot.reset()
    with page_at(bringup.url) as page:
        assert page.request("pause") is None
    bringup.process.terminate()
    assert bringup.process.wait(TIMEOUT) == OK
    said = "".join(bringup.said)
    assert "Traceback" not in said, said[-3000:]
    assert len(said) < MOST_SAID, said[-3000:]


class Lines:
    """A connection to the Unix socket whose answers are kept."""

    def __init__(self, path: Path, answers: list[bytes]) -> None:
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(str(path))
        self._answers = answers
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        with contextlib.suppress(OSError), self.socket.makefile("rb") as lines:
            self._answers += (line for line in lines if b'"error"' in line)

    def close(self) -> None:
        """Wait until all is answered; the server hangs up then."""
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_WR)
        self._reader.join()
        self.socket.close()


@pytest.mark.timeout(900 * SCALE)
def test_frames_on_the_unix_socket(bringup: Bringup) -> None:
    kinds = [item for item in sorted(methods().items()) if item[0] not in LASTING]
    answers: list[bytes] = []
    connection = Lines(bringup.socket, answers)
    n_connections = 1
    for number in range(N):
        rng = random.Random(f"{SEED}.unix.{number}")
        frame = message(rng, kinds).replace(b"\n", b" ") + b"\n"
        try:
            connection.socket.sendall(frame)
        except OSError:  # the server may hang up
            connection.close()
            connection = Lines(bringup.socket, answers)
            n_connections += 1
        if rng.random() < 0.01:
            connection.close()
            connection = Lines(bringup.socket, answers)
            n_connections += 1
    connection.close()
    print(
        f"Unix socket: {N} frames, {n_connections} connections, {len(answers)} errors"
    )
    check(bringup, answers)


# ---- WebSocket -----------------------------------------------------------------------


def handshake(url: str) -> socket.socket:
    """Return a connection to the WebSocket, after its greeting."""
    parts = urlsplit(socket_url(url))
    connection = socket.create_connection((parts.hostname, parts.port), TIMEOUT)
    path = f"{parts.path}?{parts.query}"
    request = (
        f"GET {path} HTTP/1.1\r\nHost: {parts.netloc}\r\nUpgrade: websocket\r\n"
        f"Connection: Upgrade\r\nOrigin: http://{parts.netloc}\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Version: 13\r\n\r\n"
    )
    connection.sendall(request.encode())
    answer = connection.recv(4096)
    assert answer.startswith(b"HTTP/1.1 101"), answer
    return connection


def framed(payload: bytes, first: int = 0x81, *, masked: bool = True) -> bytes:
    """Return a frame: ``first`` has FIN, the reserved bits and the kind."""
    n, bit = len(payload), 0x80 if masked else 0
    if n < 126:
        head = struct.pack(">BB", first, bit | n)
    elif n < 1 << 16:
        head = struct.pack(">BBH", first, bit | 126, n)
    else:
        head = struct.pack(">BBQ", first, bit | 127, n)
    return head + (b"\0\0\0\0" if masked else b"") + payload


BROKEN: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    lambda text, rng: framed(text, masked=False),
    lambda text, rng: framed(text, 0x81 | rng.choice((0x10, 0x20, 0x40, 0x70))),
    lambda text, rng: framed(text, 0x80 | rng.randrange(16)),
    lambda text, rng: framed(text, rng.randrange(256)),
    lambda text, rng: framed(b"\xff" + text),
    lambda text, rng: framed(struct.pack(">H", rng.randrange(1 << 16)) + text, 0x88),
    lambda text, rng: framed(b"\x03", 0x88),
    lambda text, rng: framed(text + b"x" * 200, 0x89),
    lambda text, rng: framed(text, 0x01) + framed(text, 0x81),
    lambda text, rng: framed(text, 0x80),
    lambda text, rng: struct.pack(">BBQ", 0x81, 0xFF, 1 << rng.randrange(20, 64)),
    lambda text, rng: bytes(rng.randrange(256) for _ in range(40)),
    lambda text, rng: changed(framed(text), rng),
)
"""What breaks the protocol itself, and mostly ends the connection."""


@pytest.mark.timeout(900 * SCALE)
def test_frames_on_the_websocket(bringup: Bringup) -> None:
    kinds = [item for item in sorted(methods().items()) if item[0] not in LASTING]
    answers: list[bytes] = []
    connection = handshake(bringup.url)
    n_connections = 1

    def renewed() -> socket.socket:
        nonlocal n_connections
        n_connections += 1
        connection.setblocking(False)
        with contextlib.suppress(OSError):
            answers.append(connection.recv(1 << 20))
        connection.close()
        return handshake(bringup.url)

    for number in range(N):
        rng = random.Random(f"{SEED}.web.{number}")
        text = message(rng, kinds)
        is_broken = rng.random() < 0.3
        frame = (
            rng.choice(BROKEN)(text, rng)
            if is_broken
            else framed(text, rng.choice((0x81, 0x81, 0x82)))
        )
        try:
            connection.sendall(frame)
        except OSError:
            connection = renewed()
        if is_broken or number % 40 == 39:
            connection = renewed()
    connection.close()
    print(f"WebSocket: {N} frames, {n_connections} connections")
    check(bringup, answers)
