"""A client that sends as fast as possible, for the benchmark of stops and its tests.

The client needs only the standard library, so that many clients can start at the same
time.
"""

from __future__ import annotations

import contextlib
import json
import socket
import struct
import sys
import threading
from collections.abc import Iterator
from itertools import cycle
from urllib.parse import urlsplit

MASKED, TEXT = 0x80, 0x81
GARBAGE_SIZE = 50_000
"""Size of a line that is not a request [bytes].  A message to a panel has at most 65
536 bytes."""
N_AT_ONCE = 50
"""Number of messages that are sent together."""
RTDE_PORT = 30004
START, OUTPUTS, UNKNOWN = 83, 79, 99
"""Packet types of RTDE."""


def _request(method: str, **params: object) -> bytes:
    return json.dumps({"id": 1, "method": method, "params": params}).encode()


KINDS = {
    "unknown": [_request(f"method_{k}") for k in range(100)],
    "valid": [_request("list_controllers"), _request("read_snapshot")],
    "garbage": [b"[" * GARBAGE_SIZE, b'{"method": "' + b"x" * GARBAGE_SIZE],
    "subscriptions": [_request("subscribe", rate=rate) for rate in (100.0, 500.0)],
}
"""Messages that each kind of client sends repeatedly."""
RTDE_KINDS = {
    "rtde_unknown": [struct.pack(">HB", 3, UNKNOWN)],
    "rtde_setup": [struct.pack(">HBd", 20, OUTPUTS, 500.0) + b"timestamp"],
}


def connected(address: str) -> socket.socket:
    """Return a connection to a panel's page, a UR's host or a Unix socket."""
    if address.startswith("http://"):
        return _page(address)
    if address.startswith("rtde://"):
        host = urlsplit(address).hostname
        return socket.create_connection((host, RTDE_PORT))
    peer = socket.socket(socket.AF_UNIX)
    peer.connect(address)
    return peer


def framed(address: str, message: bytes) -> bytes:
    """Return a message in the form in which it is sent to ``address``."""
    if address.startswith("rtde://"):
        return message
    if not address.startswith("http://"):
        return message + b"\n"
    size = len(message)
    if size < 126:
        header = bytes((TEXT, MASKED | size))
    else:
        header = bytes((TEXT, MASKED | 126)) + struct.pack(">H", size)
    return header + bytes(4) + message  # the mask contains only zeros


def _page(url: str) -> socket.socket:
    parts = urlsplit(url)
    peer = socket.create_connection((parts.hostname, parts.port))
    peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    peer.sendall(
        f"GET /ws?{parts.query} HTTP/1.1\r\nHost: {parts.netloc}\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
    )
    answer = b""
    while b"\r\n\r\n" not in answer:
        answer += peer.recv(1)
    return peer


def _blocks(kind: str, address: str) -> Iterator[bytes]:
    messages = (KINDS | RTDE_KINDS)[kind]
    endless = cycle([framed(address, message) for message in messages])
    while True:
        block = bytearray()
        for _ in range(N_AT_ONCE):
            block += next(endless)
            if len(block) > GARBAGE_SIZE:
                break
        yield bytes(block)


def flood(kind: str, address: str) -> None:
    """Send messages of a kind until the connection ends, and read all answers."""
    peer = connected(address)

    def read() -> None:
        with contextlib.suppress(OSError):  # the server has ended
            while peer.recv(1 << 16):
                pass

    threading.Thread(target=read, daemon=True).start()
    print("floods", flush=True)
    for block in _blocks(kind, address):
        peer.sendall(block)


if __name__ == "__main__":
    # the server has closed the connection or has ended
    with contextlib.suppress(OSError):
        flood(sys.argv[1], sys.argv[2])
