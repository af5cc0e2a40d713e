"""Client of the bridge, which sends one answer per request (see protocol.h)."""

from __future__ import annotations

import os
import select
import socket
import struct
from collections.abc import Callable, Sequence
from enum import IntEnum
from pathlib import Path
from time import perf_counter
from typing import NoReturn, final

import numpy as np

from tool0.description.bodies import Matrix
from tool0.errors import EngineError, EngineUnavailableError

VERSION = 8
"""Version of the packet format; it must equal ``kVersion`` in protocol.h."""
ANSWER_TIMEOUT = 1.5
"""Timeout for an answer [s].  With this value, a blocked server is reported within two
seconds."""
SPAWN_TIMEOUT = 12.0
"""Timeout for requests during which the bridge can wait up to 10 s [s]."""
_MAX_PACKET = 1 << 16
"""Largest size of a packet [bytes]."""
_FULL_SPEED_GAP = 1e-4
"""Longest time between an answer and the next request at full speed [s]."""
_SPIN_POLLS = 400
"""Number of polls for an answer at full speed.  One poll takes about 0.5 µs."""
_MAX_SPIN_BACKOFF = 511
"""Largest number of answers for which polling is skipped."""


class RequestKind(IntEnum):
    """Kinds of requests, with the same numbers as in protocol.h."""

    STEP = 1
    RESET = 2
    BIND = 3
    OBJECTS = 4
    SPAWN = 5
    DELETE = 6
    PLACE = 7
    CONTACTS = 8
    ATTACH = 9
    DETACH = 10
    CENTER = 11
    WRENCHES = 12
    BRAKES = 13


@final
class BridgeListener:
    """A socket to which one gzserver's bridge connects."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        # The path contains the folder's file descriptor, since the path of a socket
        # must be shorter than 108 bytes.
        folder = os.open(path.parent, os.O_PATH)
        try:
            self._socket.bind(f"/proc/self/fd/{folder}/{path.name}")
        finally:
            os.close(folder)
        self._socket.listen(1)

    def accept(
        self, dt: float, check: Callable[[], None], timeout: float
    ) -> socket.socket:
        """Return the socket of a bridge of this ``VERSION``, with time step ``dt`` [s].

        ``check`` is called while waiting, and must raise an error if the bridge can no
        longer connect.

        Raises:
            EngineUnavailableError: If no bridge connects, or if the bridge has another
                version.
        """
        deadline = perf_counter() + timeout
        self._socket.settimeout(0.1)
        while True:
            try:
                peer, _ = self._socket.accept()
                break
            except TimeoutError:
                check()
            if perf_counter() > deadline:
                raise EngineUnavailableError(
                    f"gzserver did not load the bridge within {timeout:g} s"
                )
        try:
            _handshake(peer, dt)
        except BaseException:
            peer.close()
            raise
        return peer

    def close(self) -> None:
        """Stop listening; closing twice is allowed."""
        self._socket.close()
        self._path.unlink(missing_ok=True)


def _handshake(peer: socket.socket, dt: float) -> None:
    peer.settimeout(ANSWER_TIMEOUT)
    try:
        version = struct.unpack_from("=I", peer.recv(_MAX_PACKET))[0]
    except (OSError, struct.error) as error:
        raise EngineUnavailableError(
            f"the handshake with gzserver's bridge failed: {error}"
        ) from None
    if version != VERSION:
        raise EngineUnavailableError(
            f"gzserver's bridge has version {version}, this tool0 needs {VERSION}; "
            "run `tool0 gazebo install` to compile the right one"
        )
    peer.send(struct.pack("=Id", VERSION, dt))


@final
class BridgeConnection:
    """Connection that sends requests to the bridge.

    Only the thread that executes the tick may use the connection.
    """

    def __init__(
        self, peer: socket.socket, on_lost: Callable[[str], EngineError]
    ) -> None:
        """Use the socket ``peer``, connected to the bridge.

        ``on_lost`` is called when the connection is lost.  The function ends the server
        and returns the error that the current request and all later requests raise.
        """
        self._peer = peer
        self._on_lost = on_lost
        self._loss: EngineError | None = None
        self._answer = bytearray(_MAX_PACKET)
        self._view = memoryview(self._answer)
        # In blocking mode, waiting takes one system call instead of two.
        self._peer.settimeout(None)
        self._set_timeout(ANSWER_TIMEOUT)
        poll = select.poll()
        poll.register(peer, select.POLLIN)
        self._poll = poll.poll
        self._answered = 0.0
        self._is_at_full_speed = False
        self._backoff = self._skip_spins = 0

    def send(self, packet: bytes) -> None:
        """Send a request."""
        self._is_at_full_speed = perf_counter() - self._answered < _FULL_SPEED_GAP
        try:
            self._peer.send(packet)
        except OSError:
            self._fail("gzserver is gone")

    def receive(self) -> memoryview:
        """Return the answer, which is valid until the next answer is received.

        Raises:
            EngineError: If the bridge rejects the request, or does not answer.
        """
        if self._is_at_full_speed:
            self._spin()
        try:
            size = self._peer.recv_into(self._answer)
        except BlockingIOError:
            self._fail(f"gzserver does not answer within {self._timeout:g} s")
        except OSError:
            self._fail("gzserver is gone")
        if not size:
            self._fail("gzserver is gone")
        if self._answer[0]:
            raise EngineError(self._view[4:size].tobytes().decode(errors="replace"))
        self._answered = perf_counter()
        return self._view[4:size]

    def request(
        self, kind: RequestKind, *parts: bytes, timeout: float = ANSWER_TIMEOUT
    ) -> memoryview:
        """Send a request that consists of ``parts``, and return the answer.

        Raises:
            EngineError: If the bridge rejects the request, or does not answer before
                the timeout.
        """
        if timeout != self._timeout:
            self._set_timeout(timeout)
        self.send(struct.pack("=I", kind) + b"".join(parts))
        try:
            return self.receive()
        finally:
            if self._timeout != ANSWER_TIMEOUT:
                self._set_timeout(ANSWER_TIMEOUT)

    def close(self) -> None:
        """Close the socket, which ends the server; closing twice is allowed."""
        self._peer.close()

    def _spin(self) -> None:
        """Poll for the answer, because a blocking call would return later.

        If polling does not find an answer, for example on a busy processor, polling is
        skipped for an increasing number of answers.
        """
        if self._skip_spins:
            self._skip_spins -= 1
            return
        poll = self._poll
        for _ in range(_SPIN_POLLS):
            if poll(0):
                self._backoff = 0
                return
        self._skip_spins = self._backoff = min(2 * self._backoff + 1, _MAX_SPIN_BACKOFF)

    def _set_timeout(self, seconds: float) -> None:
        if self._peer.fileno() < 0:  # closed
            return
        self._timeout = seconds
        value = struct.pack("@ll", int(seconds), round(seconds % 1.0 * 1e6))
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            self._peer.setsockopt(socket.SOL_SOCKET, option, value)

    def _fail(self, why: str) -> NoReturn:
        if self._loss is None:
            self._loss = self._on_lost(why)
            self._peer.close()
        raise self._loss.with_traceback(None) from None


def pack_text(value: str) -> bytes:
    """Return ``value`` in the bridge's format, or raise EngineError."""
    raw = value.encode()
    if b"\0" in raw:
        raise EngineError(f"{value!r} contains a zero byte, invalid in Gazebo")
    return raw + b"\0"


def pack_floats(values: Sequence[float]) -> bytes:
    """Return ``values`` in the bridge's format."""
    return struct.pack(f"={len(values)}d", *values)


def pack_pose(pose: Matrix) -> bytes:
    """Return the homogeneous matrix ``pose`` as position and quaternion (wxyz)."""
    return pack_floats([*pose[:3, 3], *quat_wxyz(pose)])


def quat_wxyz(pose: Matrix) -> list[float]:
    """Return the quaternion of ``pose``, computed from the largest component.

    ``Transform.quat_wxyz`` cannot be used, because its results differ in the last bit.
    gzserver's state after a reset, and therefore every recording, depends on this bit.

    Source: S. W. Shepperd, "Quaternion from rotation matrix" (1978).
    """
    r = pose[:3, :3]
    trace = float(np.trace(r))
    squares = [1.0 + trace, *(1.0 - trace + 2.0 * float(r[i, i]) for i in range(3))]
    k = int(np.argmax(squares))
    rows = np.array(
        [
            [squares[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], squares[1], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], squares[2], r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], squares[3]],
        ]
    )
    quat = rows[k] / (2.0 * np.sqrt(squares[k]))
    return [float(part) for part in quat]
