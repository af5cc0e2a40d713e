"""Our end of the bridge's socket: one request, one answer (see bridge/bridge.cc)."""

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

from tool0.errors import EngineError, EngineUnavailableError
from tool0.hardware.bodies import Matrix

VERSION = 6
"""Of the packets; as ``kVersion`` in bridge.cc."""
_LARGEST = 1 << 16
_HURRY = 1e-4  # [s] between an answer and the next request, at full speed
_LOOKS = 400  # for an answer to who is in a hurry; about 0.5 µs each
_SELDOM = 511  # answers at most, between looks
_PATIENCE = 1.5  # [s] for an answer: who hangs is told of within two seconds
_LONG_PATIENCE = 12.0  # [s] for what makes the bridge itself wait, 10 s at most


class Kind(IntEnum):
    """The requests, as bridge.cc counts them."""

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


@final
class Listener:
    """A socket on which the bridge of one gzserver is awaited."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        # By its folder's number, since a socket's path must be shorter than 108 bytes.
        folder = os.open(path.parent, os.O_PATH)
        try:
            self._socket.bind(f"/proc/self/fd/{folder}/{path.name}")
        finally:
            os.close(folder)
        self._socket.listen(1)

    def accept(
        self, dt: float, check: Callable[[], None], timeout: float
    ) -> tuple[socket.socket, str]:
        """Return the socket of a bridge of our version, and its Gazebo's version.

        Args:
            dt: The step that it is to make [s].
            check: Called while nobody comes; raises if nobody will.
            timeout: How long to wait [s].

        Raises:
            EngineUnavailableError: If nobody comes, or a wrong bridge does.
        """
        waited = 0.0
        self._socket.settimeout(0.1)
        while True:
            try:
                peer, _ = self._socket.accept()
                break
            except TimeoutError:
                check()
                waited += 0.1
                if waited > timeout:
                    raise EngineUnavailableError(
                        f"gzserver did not load the bridge within {timeout:g} s"
                    ) from None
        try:
            return peer, _greet(peer, dt)
        except BaseException:
            peer.close()
            raise

    def close(self) -> None:
        """Take no more callers; closing twice is allowed."""
        self._socket.close()
        self._path.unlink(missing_ok=True)


def _greet(peer: socket.socket, dt: float) -> str:
    peer.settimeout(_PATIENCE)
    try:
        hello = peer.recv(_LARGEST)
        version = struct.unpack_from("=I", hello)[0]
    except (OSError, struct.error) as error:
        raise EngineUnavailableError(
            f"gzserver's bridge does not introduce itself: {error}"
        ) from None
    if version != VERSION:
        raise EngineUnavailableError(
            f"gzserver's bridge speaks version {version}, this tool0 {VERSION}; "
            "run `tool0 gazebo install` to compile the right one"
        )
    peer.send(struct.pack("=Id", VERSION, dt))
    return hello[4:].decode(errors="replace")


@final
class Connection:
    """Asks the bridge.  Only the thread that owns the tick may use it."""

    def __init__(
        self, peer: socket.socket, when_lost: Callable[[str], EngineError]
    ) -> None:
        """Talk over ``peer``; ``when_lost`` ends the server and tells what it said.

        Who asks again after that is told the same again.
        """
        self._peer = peer
        self._when_lost = when_lost
        self._loss: EngineError | None = None
        self._answer = bytearray(_LARGEST)
        self._view = memoryview(self._answer)
        # In blocking mode, so that waiting takes one system call and not two.
        self._peer.settimeout(None)
        self._set_patience(_PATIENCE)
        poll = select.poll()
        poll.register(peer, select.POLLIN)
        self._poll = poll.poll
        self._answered = 0.0
        self._is_hurried = False
        self._vain = self._unlooked = 0

    def send(self, packet: bytes) -> None:
        """Send a request."""
        self._is_hurried = perf_counter() - self._answered < _HURRY
        try:
            self._peer.send(packet)
        except OSError:
            self._fail("gzserver is gone")

    def receive(self) -> memoryview:
        """Return the answer, valid until the next one comes.

        Raises:
            EngineError: If the bridge refuses, or there is no answer.
        """
        if self._is_hurried:
            self._look()
        try:
            size = self._peer.recv_into(self._answer)
        except BlockingIOError:
            self._fail(f"gzserver does not answer within {self._patience:g} s")
        except OSError:
            self._fail("gzserver is gone")
        if not size:
            self._fail("gzserver is gone")
        if self._answer[0]:
            raise EngineError(self._view[4:size].tobytes().decode(errors="replace"))
        self._answered = perf_counter()
        return self._view[4:size]

    def _look(self) -> None:
        """Wait for an answer awake, for who sleeps takes long to wake up.

        Where processors are scarce that is in vain, and it looks seldom.
        """
        if self._unlooked:
            self._unlooked -= 1
            return
        poll = self._poll
        for _ in range(_LOOKS):
            if poll(0):
                self._vain = 0
                return
        self._unlooked = self._vain = min(2 * self._vain + 1, _SELDOM)

    def ask(self, kind: Kind, *parts: bytes) -> memoryview:
        """Send a request of ``parts`` and return its answer."""
        self.send(struct.pack("=I", kind) + b"".join(parts))
        return self.receive()

    def spawn(
        self, name: str, file: Path, pose: Matrix, *, is_object: bool = False
    ) -> None:
        """Add the model of a URDF or SDF file to the world.

        Where an object is, how it moves, and where it goes at a reset are asked for
        in the order in which objects came.

        Raises:
            EngineError: If Gazebo does not take it.
        """
        self._ask_patiently(
            Kind.SPAWN,
            text(name),
            text(str(file)),
            pose_bytes(pose),
            struct.pack("=I", is_object),
        )

    def delete(self, name: str) -> None:
        """Take the model called ``name`` out of the world.

        Raises:
            EngineError: If there is none.
        """
        self._ask_patiently(Kind.DELETE, text(name))

    def close(self) -> None:
        """Hang up, which ends the server; closing twice is allowed."""
        self._peer.close()

    def _ask_patiently(self, kind: Kind, *parts: bytes) -> None:
        self._set_patience(_LONG_PATIENCE)
        try:
            self.ask(kind, *parts)
        finally:
            self._set_patience(_PATIENCE)

    def _set_patience(self, seconds: float) -> None:
        if self._peer.fileno() < 0:  # closed
            return
        self._patience = seconds
        value = struct.pack("@ll", int(seconds), round(seconds % 1.0 * 1e6))
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            self._peer.setsockopt(socket.SOL_SOCKET, option, value)

    def _fail(self, why: str) -> NoReturn:
        if self._loss is None:
            self._loss = self._when_lost(why)
            self._peer.close()
        raise self._loss.with_traceback(None) from None


def text(value: str) -> bytes:
    """Return ``value`` as the bridge reads it, or raise EngineError."""
    raw = value.encode()
    if b"\0" in raw:
        raise EngineError(f"{value!r} has a zero byte, which Gazebo cannot name")
    return raw + b"\0"


def numbers(values: Sequence[float]) -> bytes:
    """Return ``values`` as the bridge reads them."""
    return struct.pack(f"={len(values)}d", *values)


def pose_bytes(pose: Matrix) -> bytes:
    """Return the homogeneous matrix ``pose`` as position and quaternion w x y z."""
    return numbers([*pose[:3, 3], *quat_wxyz(pose)])


def quat_wxyz(pose: Matrix) -> list[float]:
    """Return the rotation of ``pose``, by the largest of the four components.

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
