"""Connections to Robotiq grippers over the URCap's socket, Modbus TCP or Modbus RTU."""

from __future__ import annotations

import contextlib
import os
import re
import select
import socket
import struct
import termios
import time
import tty
from typing import Final, NamedTuple, Protocol, final

from tool0.devices.modbus_frames import ERROR, HEADER, ModbusFunction, checksum
from tool0.devices.robotiq_registers import (
    BLOCK_BYTES,
    Activation,
    CommandRegisters,
    ObjectStatus,
)
from tool0.errors import TransportError

URCAP_PORT: Final = 63352
_COMMAND_REGISTER: Final = 1000
_STATUS_REGISTER: Final = 2000
_REGISTERS: Final = 3
"""Number of registers in a command and in a status; each is six bytes long."""
_UNIT: Final = 9
"""The gripper's factory-set Modbus address."""
_ANSWER: Final = re.compile(rb"([A-Z]{3}) (\d{1,3})\n")
_BAUD: Final = termios.B115200
"""Baud rate (from Robotiq's instruction manual, "Modbus RTU communication")."""


class GripperReading(NamedTuple):
    """Status of a gripper at one reading."""

    position: int
    """Position count: 0 is open, 255 is closed."""
    object_status: ObjectStatus
    activation: Activation
    fault: int
    """Fault code (gFLT); 0 if there is no fault."""
    current: int
    """Motor current [10 mA]."""


class GripperLink(Protocol):
    """A connection to a gripper; a lost connection raises TransportError."""

    def read(self) -> GripperReading | None:
        """Return the gripper's status; None if the gripper has no power."""

    def write(self, command: CommandRegisters) -> None:
        """Send a command to the gripper."""

    def close(self) -> None:
        """End the connection."""


@final
class UrcapLink:
    """A connection through the socket of Robotiq's URCap on the robot's controller."""

    def __init__(self, host: str, port: int = URCAP_PORT, timeout: float = 1.0) -> None:
        """Connect to the URCap's socket.

        Raises:
            TransportError: If the connection fails, for example because the URCap is
                not installed.
        """
        self._peer = f"the gripper's URCap at {host}:{port}"
        try:
            self._socket = socket.create_connection((host, port), timeout)
        except OSError as error:
            raise TransportError(f"{self._peer}: {error}") from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._slow: tuple[int, int] = (Activation.RESET, 0)
        """Activation and fault; only every eighth reading updates them."""
        self._reads = 0

    def read(self) -> GripperReading | None:
        position, status = self._get("POS"), self._get("OBJ")
        if position is None or status is None:
            return None
        if self._reads % 8 == 0 or self._slow[0] != Activation.COMPLETE:
            self._slow = (self._get("STA") or 0, self._get("FLT") or 0)
        self._reads += 1
        activation, fault = self._slow
        return GripperReading(
            position,
            ObjectStatus(status & 3),
            Activation(activation if activation in {0, 1, 3} else 1),
            fault,
            0,
        )

    def write(self, command: CommandRegisters) -> None:
        words = (
            f"ACT {command.activate:d} GTO {command.go_to:d} "
            f"POS {command.position} SPE {command.speed} FOR {command.force}"
        )
        answer = self._exchange(f"SET {words}\n".encode(), (b"ack", b"?"))
        if b"ack" not in answer:
            raise TransportError(f"{self._peer} refuses a command: {answer!r}")

    def _get(self, name: str) -> int | None:
        answer = self._exchange(f"GET {name}\n".encode(), (b"\n", b"?"))
        match = _ANSWER.search(answer)
        if match is None or match[1].decode() != name:
            return None
        return int(match[2])

    def _exchange(self, question: bytes, ends: tuple[bytes, bytes]) -> bytes:
        answer = b""
        try:
            self._socket.sendall(question)
            while not any(end in answer for end in ends):
                data = self._socket.recv(1024)
                if not data:
                    raise TransportError(f"{self._peer} has closed the connection")
                answer += data
        except OSError as error:
            raise TransportError(f"{self._peer}: {error}") from None
        return answer

    def close(self) -> None:
        self._socket.close()


class _Transport(Protocol):
    """Sends requests to a Modbus unit and receives the unit's responses."""

    peer: str

    def exchange(self, request: bytes, length: int) -> bytes:
        """Return the response to a request; ``length`` is a valid response's length."""

    def close(self) -> None: ...


@final
class ModbusLink:
    """A connection that reads and writes the gripper's registers over Modbus."""

    def __init__(self, transport: _Transport) -> None:
        self._transport = transport

    def read(self) -> GripperReading | None:
        span = struct.pack(">HH", _STATUS_REGISTER, _REGISTERS)
        request = bytes([ModbusFunction.READ_INPUT]) + span
        response = self._checked(request, 2 + 2 * _REGISTERS)
        state, _, fault, _, position, current = response[2:8]
        activation = state >> 4 & 3
        return GripperReading(
            position,
            ObjectStatus(state >> 6),
            Activation(activation if activation in {0, 1, 3} else 1),
            fault & 0x0F,
            current,
        )

    def write(self, command: CommandRegisters) -> None:
        span = struct.pack(">HHB", _COMMAND_REGISTER, _REGISTERS, 2 * _REGISTERS)
        block = command.encode()[: 2 * _REGISTERS]
        self._checked(bytes([ModbusFunction.WRITE]) + span + block, 5)

    def _checked(self, request: bytes, length: int) -> bytes:
        response = self._transport.exchange(request, length)
        if len(response) != length or response[0] != request[0]:
            code = response[1] if len(response) > 1 and response[0] & ERROR else None
            reason = f"exception {code}" if code else f"{response!r}"
            raise TransportError(
                f"{self._transport.peer} answers function {request[0]} with {reason}"
            )
        return response

    def close(self) -> None:
        self._transport.close()


@final
class ModbusTcp:
    """Modbus TCP, which gateways and some grippers support."""

    def __init__(self, host: str, port: int = 502, timeout: float = 1.0) -> None:
        """Connect to the unit; raise TransportError if this fails."""
        self.peer = f"the gripper at {host}:{port} (Modbus TCP)"
        self._number = 0
        try:
            self._socket = socket.create_connection((host, port), timeout)
        except OSError as error:
            raise TransportError(f"{self.peer}: {error}") from None

    def exchange(self, request: bytes, length: int) -> bytes:
        self._number = number = self._number + 1 & 0xFFFF
        header = HEADER.pack(number, 0, len(request) + 1, _UNIT)
        try:
            self._socket.sendall(header + request)
            head = self._exactly(HEADER.size)
            found, protocol, rest, _ = HEADER.unpack(head)
            body = self._exactly(max(rest - 1, 0))
        except OSError as error:
            raise TransportError(f"{self.peer}: {error}") from None
        if found != number or protocol:
            raise TransportError(f"{self.peer} answers another request: {head!r}")
        return body

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            received = self._socket.recv(count - len(data))
            if not received:
                raise TransportError(f"{self.peer} has closed the connection")
            data += received
        return data

    def close(self) -> None:
        self._socket.close()


@final
class ModbusRtu:
    """Modbus RTU on a serial port: 115200 baud, 8 data bits, no parity."""

    def __init__(self, path: str, timeout: float = 0.5) -> None:
        """Open the port; raise TransportError if this fails."""
        self.peer = f"the gripper at {path} (Modbus RTU)"
        self._timeout = timeout
        try:
            self._port = os.open(path, os.O_RDWR | os.O_NOCTTY)
            tty.setraw(self._port)
            settings = termios.tcgetattr(self._port)
            settings[4] = settings[5] = _BAUD
            termios.tcsetattr(self._port, termios.TCSANOW, settings)
        except (OSError, termios.error) as error:
            raise TransportError(f"{self.peer}: {error}") from None

    def exchange(self, request: bytes, length: int) -> bytes:
        frame = bytes([_UNIT]) + request
        size, answer = length + 3, b""
        try:
            termios.tcflush(self._port, termios.TCIFLUSH)
            os.write(self._port, frame + checksum(frame))
            end = time.monotonic() + self._timeout
            while len(answer) < size and not (len(answer) == 5 and answer[1] & ERROR):
                left = end - time.monotonic()
                if left < 0.0 or not select.select([self._port], [], [], left)[0]:
                    raise TransportError(f"{self.peer} does not answer")
                answer += os.read(self._port, BLOCK_BYTES + size)
        except (OSError, termios.error) as error:
            raise TransportError(f"{self.peer}: {error}") from None
        if answer[:1] != bytes([_UNIT]) or checksum(answer[:-2]) != answer[-2:]:
            raise TransportError(
                f"{self.peer} answers {answer!r}: its checksum is wrong"
            )
        return answer[1:-2]

    def close(self) -> None:
        with contextlib.suppress(OSError):
            os.close(self._port)
