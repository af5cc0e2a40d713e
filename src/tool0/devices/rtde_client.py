"""A client of UR's real-time data exchange (RTDE) that uses blocking sockets."""

from __future__ import annotations

import logging
import select
import socket
import struct
import threading
import time
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple, final

from tool0.devices.rtde_packets import (
    LENGTHS,
    PORT,
    PacketBuffer,
    PacketType,
    field_names,
    layout,
    packet,
)
from tool0.errors import TransportError

logger = logging.getLogger(__name__)

_VERSION: Final = 2
_NOT_THERE: Final = ("NOT_FOUND", "IN_USE")
_CHUNK: Final = 1 << 16

Package = tuple[Any, ...]
"""Values of a data package in the order of the recipe, with flattened vectors."""


class ControllerVersion(NamedTuple):
    """Software version that a controller reports."""

    major: int
    minor: int
    bugfix: int
    build: int

    @property
    def is_e_series(self) -> bool:
        """Whether the controller is an e-Series (500 Hz) rather than a CB3 (125 Hz)."""
        return self.major >= 5


class _Input(NamedTuple):
    recipe: int
    values: struct.Struct


@final
class RtdeClient:
    """Reads the outputs and writes the inputs of a robot's controller.

    Call ``receive`` from only one thread; any thread may call ``send``.
    """

    def __init__(
        self,
        host: str,
        port: int = PORT,
        *,
        outputs: Sequence[str],
        optional: Sequence[str] = (),
        inputs: Mapping[str, Sequence[str]] | None = None,
        timeout: float = 2.0,
    ) -> None:
        """Connect and set up the fields to read and write.

        Args:
            host: Host name or address of the controller.
            port: RTDE port.
            outputs: Fields to read at the controller's rate.
            optional: Additional fields to read if the controller supports them.
            inputs: Recipes of fields to write; the keys are the names of the recipes.
            timeout: Maximum time to wait for an answer [s].

        Raises:
            TransportError: If the controller cannot be reached, does not support RTDE,
                or lacks a field.
        """
        self.peer = f"RTDE of {host}:{port}"
        self._buffer = PacketBuffer()
        self._lock = threading.Lock()
        self._pending: list[tuple[int, bytes]] = []
        try:
            self._socket = socket.create_connection((host, port), timeout)
        except OSError as error:
            raise TransportError(f"{self.peer}: {error}") from None
        try:
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._timeout = timeout
            self._negotiate()
            self.version = self._controller_version()
            self.rate = 500.0 if self.version.is_e_series else 125.0
            """Rate at which the controller sends packages, which is its control rate
            [Hz]."""
            self.columns, self._recipe, self._layout = self._set_up(outputs, optional)
            self._inputs = {
                name: self._set_up_input(fields)
                for name, fields in (inputs or {}).items()
            }
        except BaseException:
            self._socket.close()
            raise

    @property
    def local_address(self) -> str:
        """This machine's address on the connection."""
        return str(self._socket.getsockname()[0])

    def start(self) -> None:
        """Start the stream of packages from the controller."""
        if not self._ask(PacketType.START, b"")[:1] == b"\x01":
            raise TransportError(f"{self.peer} refuses to start")

    def receive(self, timeout: float) -> list[Package]:
        """Return the packages that have been received, oldest first.

        The call waits up to ``timeout`` [s] for the first package. If no package is
        received, the list is empty.

        Raises:
            TransportError: If the connection is lost.
        """
        found: list[Package] = []
        end = time.monotonic() + timeout
        while not found:
            if not self._pending:
                left = end - time.monotonic()
                if left < 0.0 or not self._wait(left):
                    return found
                self._read()
            for kind, payload in self._pending:
                if kind == PacketType.DATA and payload[:1] == self._recipe:
                    found.append(self._layout.unpack_from(payload))
                elif kind == PacketType.TEXT:
                    logger.warning("%s: %s", self.peer, _text(payload))
            self._pending.clear()
        return found

    def send(self, name: str, values: Sequence[float]) -> None:
        """Write the fields of an input recipe.

        Raises:
            TransportError: If the connection is lost.
        """
        recipe, numbers = self._inputs[name]
        payload = bytes((recipe,)) + numbers.pack(*values)
        self._send(PacketType.DATA, payload)

    def close(self) -> None:
        """End the connection."""
        self._socket.close()

    # ---- set-up ---------------------------------------------------------------------

    def _negotiate(self) -> None:
        answer = self._ask(PacketType.PROTOCOL_VERSION, struct.pack(">H", _VERSION))
        if answer[:1] != b"\x01":
            raise TransportError(
                f"{self.peer} does not speak version {_VERSION} of the protocol; "
                "PolyScope 3.5 and 5 do"
            )

    def _controller_version(self) -> ControllerVersion:
        answer = self._ask(PacketType.CONTROL_VERSION, b"")
        try:
            return ControllerVersion(*struct.unpack_from(">4I", answer))
        except struct.error:
            raise self._unexpected("the controller's version", answer) from None

    def _set_up(
        self, outputs: Sequence[str], optional: Sequence[str]
    ) -> tuple[Mapping[str, slice], bytes, struct.Struct]:
        """Set up the fields to read; return their columns, recipe number and layout."""
        names = [*outputs, *optional]
        types, _ = self._recipe_of(names)
        lacking = [n for n, t in zip(names, types, strict=True) if t in _NOT_THERE]
        if missing := [name for name in lacking if name in outputs]:
            raise TransportError(
                f"{self.peer} lacks {', '.join(missing)}: PolyScope "
                f"{'.'.join(map(str, self.version[:2]))} is too old"
            )
        names = [name for name in names if name not in lacking]
        types, recipe = self._recipe_of(names)
        columns, start = {}, 0
        for name, kind in zip(names, types, strict=True):
            columns[name] = slice(start, start + LENGTHS[kind])
            start += LENGTHS[kind]
        data = struct.Struct(">x" + layout(types, recipe_id=False).format[1:])
        return columns, recipe, data

    def _recipe_of(self, names: Sequence[str]) -> tuple[tuple[str, ...], bytes]:
        """Return the types of outputs and the number of a recipe that contains them."""
        payload = struct.pack(">d", self.rate) + ",".join(names).encode()
        answer = self._ask(PacketType.SETUP_OUTPUTS, payload)
        return self._types(answer, len(names)), answer[:1]

    def _set_up_input(self, fields: Sequence[str]) -> _Input:
        answer = self._ask(PacketType.SETUP_INPUTS, ",".join(fields).encode())
        types = self._types(answer, len(fields))
        lacking = [
            f"{name} ({kind})"
            for name, kind in zip(fields, types, strict=True)
            if kind in _NOT_THERE
        ]
        if lacking:
            raise TransportError(
                f"{self.peer} refuses inputs: {', '.join(lacking)}; another client "
                "controls the robot if they are IN_USE"
            )
        return _Input(answer[0], layout(types, recipe_id=False))

    def _types(self, answer: bytes, count: int) -> tuple[str, ...]:
        types = field_names(answer[1:])
        known = {*LENGTHS, *_NOT_THERE}
        if len(types) != count or not known.issuperset(types):
            raise self._unexpected(f"the types of {count} fields", answer)
        return types

    # ---- the connection -------------------------------------------------------------

    def _ask(self, kind: PacketType, payload: bytes) -> bytes:
        """Send a packet and return the answer of the same type."""
        self._send(kind, payload)
        end = time.monotonic() + self._timeout
        while True:
            for k, (found, answer) in enumerate(self._pending):
                if found == kind:
                    del self._pending[: k + 1]
                    return answer
                if found == PacketType.TEXT:
                    logger.warning("%s: %s", self.peer, _text(answer))
            self._pending.clear()
            if not self._wait(end - time.monotonic()):
                raise TransportError(
                    f"{self.peer} does not answer '{kind.name}' within "
                    f"{self._timeout:g} s"
                )
            self._read()

    def _wait(self, timeout: float) -> bool:
        """Wait for data; return whether data was received."""
        try:
            return bool(select.select([self._socket], [], [], max(timeout, 0.0))[0])
        except (OSError, ValueError) as error:
            raise TransportError(f"{self.peer}: {error}") from None

    def _read(self) -> None:
        try:
            data = self._socket.recv(_CHUNK)
        except OSError as error:
            raise TransportError(f"{self.peer}: {error}") from None
        if not data:
            raise TransportError(f"{self.peer} has closed the connection")
        try:
            self._pending += self._buffer.feed(data)
        except TransportError as error:
            raise TransportError(f"{self.peer}: {error}") from None

    def _send(self, kind: PacketType, payload: bytes) -> None:
        try:
            with self._lock:
                self._socket.sendall(packet(kind, payload))
        except OSError as error:
            raise TransportError(f"{self.peer}: {error}") from None

    def _unexpected(self, what: str, answer: bytes) -> TransportError:
        return TransportError(f"{self.peer}: expected {what}, got {answer[:40]!r}")


def _text(payload: bytes) -> str:
    """Return the text of a controller's message in the layout of protocol version 2."""
    length = payload[0] if payload else 0
    return payload[1 : 1 + length].decode(errors="replace")
