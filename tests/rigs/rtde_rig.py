"""A bring-up with the UR interface, for real clients, and a recorder of RTDE."""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import threading
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from ros import Bringup
from ur_address import free_host

import tool0

Array = NDArray[np.float64]

_HEADER = struct.Struct(">HB")
_FORMATS = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
}
_TIMEOUT = 20.0


@contextlib.contextmanager
def ur_bringup(*options: str) -> Iterator[tuple[str, tool0.Robot]]:
    """Bring up a UR in another process; yield its address, and the robot."""
    host = free_host()
    with (
        contextlib.closing(
            Bringup(os.environ, "--ur", "--ur-host", host, *options)
        ) as bringup,
        pytest.MonkeyPatch.context() as patch,
    ):
        bringup.wait()
        patch.setenv("XDG_RUNTIME_DIR", bringup.runtime_folder)
        try:
            with tool0.connect() as robot:
                yield host, robot
        finally:
            for name, text in bringup.outputs().items():
                print(f"{name}:\n{text}")


class RtdeClient:
    """A connection of RTDE that shows every packet."""

    def __init__(self, host: str, version: int = 2) -> None:
        self._socket = socket.create_connection((host, 30004), timeout=_TIMEOUT)
        self._stream = self._socket.makefile("rb")
        self.version = version
        self._layout = struct.Struct("")
        self._lengths: list[int] = []
        if version > 1:
            assert self.ask("V", struct.pack(">H", version)) == b"\1"

    def __enter__(self) -> RtdeClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._socket.close()
        self._stream.close()

    def send(self, kind: str, payload: bytes = b"") -> None:
        self._socket.sendall(_HEADER.pack(3 + len(payload), ord(kind)) + payload)

    def read(self) -> tuple[str, bytes]:
        """Return the type and the payload of the next packet; "" at the end."""
        header = self._stream.read(3)
        if len(header) < 3:
            return "", b""
        size, kind = _HEADER.unpack(header)
        return chr(kind), self._stream.read(size - 3)

    def ask(self, kind: str, payload: bytes = b"") -> bytes:
        """Send a packet; return the payload of the next one of the same type."""
        self.send(kind, payload)
        while True:
            other, reply = self.read()
            assert other, "the server has closed the connection"
            if other == kind:
                return reply

    def receive(self, names: Sequence[str], rate: float = 500.0) -> list[str]:
        """Set up outputs; return their types."""
        payload = ",".join(names).encode()
        if self.version > 1:
            payload = struct.pack(">d", rate) + payload
        reply = self.ask("O", payload)
        types = reply[self.version > 1 :].decode().split(",")
        if "NOT_FOUND" not in types:
            formats = [_FORMATS[name] for name in types]
            self._lengths = [int(f[0]) if len(f) > 1 else 1 for f in formats]
            self._layout = struct.Struct(">" + "".join(formats))
        return types

    def start(self) -> None:
        assert self.ask("S") == b"\1"

    def sample(self) -> list[Any]:
        """Return the values of the next data packet; vectors are tuples."""
        while True:
            kind, payload = self.read()
            assert kind, "the server has closed the connection"
            if kind == "U":
                break
        numbers = iter(self._layout.unpack(payload[self.version > 1 :]))
        return [
            next(numbers) if n == 1 else tuple(next(numbers) for _ in range(n))
            for n in self._lengths
        ]


class Recorder:
    """Records fields of RTDE, every sample, while it is entered."""

    def __init__(self, host: str, *names: str) -> None:
        self._names = ("timestamp", *names)
        self._client = RtdeClient(host)
        assert "NOT_FOUND" not in self._client.receive(self._names)
        self._samples: list[list[Any]] = []
        self._until = np.inf
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Recorder:
        self._client.start()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Record for another 50 ms, then no longer."""
        self._until = self._samples[-1][0] + 0.05 if self._samples else 0.0
        self._thread.join(_TIMEOUT)
        self._client.close()

    def _run(self) -> None:
        while True:
            self._samples.append(self._client.sample())
            if self._samples[-1][0] >= self._until:
                return

    def __getitem__(self, name: str) -> Array:
        """Return the values of a field, shape (n,) or (n, 6)."""
        column = self._names.index(name)
        return np.array([sample[column] for sample in self._samples])

    @property
    def time(self) -> Array:
        return self["timestamp"]
