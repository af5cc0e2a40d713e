"""Connections to tool0's program on the controller, for knots, stops and commands.

The program connects to tool0 over two sockets.  On each socket, the program first sends
a secret number, so that no other process can impersonate the program.  Messages are
sent immediately, from any thread.
"""

from __future__ import annotations

import contextlib
import logging
import secrets
import socket
import struct
import threading
from collections.abc import Sequence
from typing import Final, NamedTuple, final

from tool0.engines.real_robot.control_program import (
    COMMAND_SCALE,
    KINDS,
    N_ARGUMENTS,
    SCALE,
    CommandKind,
    MessageKind,
)
from tool0.errors import TransportError

logger = logging.getLogger(__name__)

BEAT: Final = 0.005
"""Period of the messages that only show that tool0 is running [s].  The period is
short, so that TCP detects a lost message quickly."""
_KNOT: Final = struct.Struct(">14i")
_COMMAND: Final = struct.Struct(">30i")
_HELLO: Final = struct.Struct(">2i")
_KNOTS, _COMMANDS = 1, 2
_SEND_TIMEOUT: Final = 0.05
"""Longest wait for space in the buffer of a socket [s].  After this time, the link is
considered lost."""
_HELLO_TIMEOUT: Final = 2.0


class Knot(NamedTuple):
    """Positions and velocities of the joints in one period of the program."""

    step: int
    positions: Sequence[float]
    """Positions of the joints [rad]."""
    velocities: Sequence[float]
    """Velocities of the joints [rad/s]."""


@final
class MotionLink:
    """Link that waits for the program and sends messages from any thread."""

    def __init__(self, host: str, port: int = 0) -> None:
        """Listen at an address that the robot can reach.

        Raises:
            TransportError: If the link cannot listen at the address.
        """
        self.token = secrets.randbelow(1 << 31)
        """Secret number that the program must send first."""
        self._lock = threading.Lock()
        self._ends = threading.Event()
        self._sockets: dict[int, socket.socket] = {}
        self._n_commands = 0
        try:
            self._listener = socket.create_server((host, port), backlog=4)
        except OSError as error:
            raise TransportError(
                f"cannot listen for the robot's program at {host}:{port}: {error}"
            ) from None
        self.address: tuple[str, int] = self._listener.getsockname()[:2]
        """Address and port at which the link listens."""
        self._heart = threading.Thread(
            target=self._beat, name="tool0 heartbeat", daemon=True
        )
        self._heart.start()

    @property
    def is_connected(self) -> bool:
        """Whether the program is connected; a loss may not have been detected yet."""
        return len(self._sockets) == len((_KNOTS, _COMMANDS))

    def accept(self, timeout: float) -> None:
        """Wait for the program's connections, up to ``timeout`` [s].

        Earlier connections are closed.

        Raises:
            TransportError: If the program does not connect before the timeout.
        """
        self.disconnect()
        found: dict[int, socket.socket] = {}
        self._listener.settimeout(timeout)
        try:
            while len(found) < len((_KNOTS, _COMMANDS)):
                connection, peer = self._listener.accept()
                kind = self._greeted(connection)
                if kind is None or kind in found:
                    logger.warning("refused a connection of %s:%s", *peer[:2])
                    connection.close()
                else:
                    found[kind] = connection
        except OSError:
            for connection in found.values():
                connection.close()
            host, port = self.address
            raise TransportError(
                f"the robot's program did not connect to {host}:{port} within "
                f"{timeout:g} s: does a firewall block the port, or does the robot "
                "reach this machine under another address (`callback_host`)?"
            ) from None
        with self._lock:
            self._sockets = found

    def _greeted(self, connection: socket.socket) -> int | None:
        """Return the kind of a program connection, or None for another client."""
        connection.settimeout(_HELLO_TIMEOUT)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        data = b""
        try:
            while len(data) < _HELLO.size:
                received = connection.recv(_HELLO.size - len(data))
                if not received:
                    return None
                data += received
        except OSError:
            return None
        token, kind = _HELLO.unpack(data)
        connection.settimeout(_SEND_TIMEOUT)
        return kind if token == self.token and kind in {_KNOTS, _COMMANDS} else None

    def send_knots(self, knots: Sequence[Knot], first: MessageKind) -> None:
        """Send knots; ``first`` is the message kind of the first knot."""
        kind, data = first + KINDS * (len(knots) - 1), bytearray()
        for step, positions, velocities in knots:
            numbers = (round(SCALE * x) for x in (*positions, *velocities))
            data += _KNOT.pack(kind, step, *numbers)
            kind = MessageKind.KNOT
        if data:
            self._send(_KNOTS, data)

    def _beat(self) -> None:
        """Periodically send messages that show that tool0 and the network work."""
        message = _message(MessageKind.NOTHING)
        while not self._ends.wait(BEAT):
            self._send(_KNOTS, message)

    def brake(self, periods: int = 0) -> None:
        """Stop the arm on its path within ``periods``; 0 means the default duration."""
        self._send(_KNOTS, _message(MessageKind.BRAKE, periods))

    def end(self) -> None:
        """Stop the arm and end the program."""
        self._send(_KNOTS, _message(MessageKind.END))

    def command(self, kind: CommandKind, arguments: Sequence[float] = ()) -> int:
        """Send a command to the program, and return the command's number.

        Raises:
            TransportError: If the program is not connected.
        """
        filled = (*arguments, *[0.0] * (N_ARGUMENTS - len(arguments)))
        numbers = [round(COMMAND_SCALE * x) for x in filled]
        with self._lock:
            self._n_commands = number = self._n_commands % 0x3FFFFFFF + 1
        if not self._send(_COMMANDS, _COMMAND.pack(kind, number, *numbers)):
            raise TransportError(
                "tool0's program does not run on the robot; enable motion first"
            )
        return number

    def _send(self, kind: int, data: bytes | bytearray) -> bool:
        """Send a message, and return whether the program was connected."""
        with self._lock:
            connection = self._sockets.get(kind)
            if connection is None:
                return False
            try:
                connection.sendall(data)
            except OSError:
                self._drop()
                return False
        return True

    def disconnect(self) -> None:
        """Close the connections, so that the arm comes to rest and the program ends."""
        with self._lock:
            self._drop()

    def _drop(self) -> None:
        for connection in self._sockets.values():
            with contextlib.suppress(OSError):
                connection.close()
        self._sockets = {}

    def close(self) -> None:
        """Close the link, so that the arm comes to rest."""
        self._ends.set()
        self._heart.join()
        self.disconnect()
        self._listener.close()


def _message(kind: MessageKind, period: int = 0) -> bytes:
    return _KNOT.pack(kind, period, *[0] * 12)
