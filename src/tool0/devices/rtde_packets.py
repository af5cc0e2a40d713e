"""Packets of UR's real-time data exchange (RTDE).

A packet consists of its size (uint16) including the header, its type (uint8) and a
payload. Numbers are big-endian. Source, which contains the names and types of all
fields:
https://docs.universal-robots.com/tutorials/communication-protocol-tutorials/rtde-guide.html
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import IntEnum
from struct import Struct
from typing import Final, final

from tool0.errors import TransportError

PORT: Final = 30004
VERSIONS: Final = (1, 2)
"""Supported versions of the protocol. A connection starts with version 1."""
MAX_PACKET: Final = 65535
"""Maximum size of a packet that a client may send [bytes]."""
MAX_NAMES: Final = 1 << 15
"""Maximum size of a list of field names [bytes]. A list of all fields is 9 kB long."""

_HEADER: Final = Struct(">HB")


class PacketType(IntEnum):
    """Type of a packet, which is a letter."""

    PROTOCOL_VERSION = ord("V")
    CONTROL_VERSION = ord("v")
    TEXT = ord("M")
    DATA = ord("U")
    SETUP_OUTPUTS = ord("O")
    SETUP_INPUTS = ord("I")
    START = ord("S")
    PAUSE = ord("P")


class Level(IntEnum):
    """Severity of a text message."""

    EXCEPTION = 0
    ERROR = 1
    WARNING = 2
    INFO = 3


FORMATS: Final = {
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
"""The ``struct`` format of each field type."""

LENGTHS: Final = {
    name: int(layout[0]) if len(layout) > 1 else 1 for name, layout in FORMATS.items()
}
"""Number of values in a field of each type."""


def packet(kind: PacketType, payload: bytes = b"") -> bytes:
    """Return a packet with a header and a payload."""
    return _HEADER.pack(_HEADER.size + len(payload), kind) + payload


def text_packet(text: str, level: Level, version: int) -> bytes:
    """Return a text message to a client in the layout of a protocol version."""
    message = text.encode(errors="replace")[:255]
    if version == 1:
        return packet(PacketType.TEXT, bytes((level,)) + message)
    source = b"tool0"
    return packet(
        PacketType.TEXT,
        bytes((len(message),))
        + message
        + bytes((len(source),))
        + source
        + bytes((level,)),
    )


def field_names(payload: bytes) -> tuple[str, ...]:
    """Return the field names in a setup packet; a trailing comma is ignored.

    Raises:
        TransportError: If the list is too long or is not ASCII.
    """
    if len(payload) > MAX_NAMES:
        message = f"{len(payload)} bytes of field names; at most {MAX_NAMES}"
        raise TransportError(message)
    try:
        text = payload.decode("ascii")
    except UnicodeDecodeError as error:
        message = "field names must be ASCII"
        raise TransportError(message) from error
    names = [name.strip() for name in text.split(",")]
    while names and not names[-1]:
        names.pop()
    return tuple(names)


def layout(types: Sequence[str], *, recipe_id: bool) -> Struct:
    """Return the binary layout of a data packet with fields of these types.

    If ``recipe_id`` is set, the first byte is the number of the recipe.
    """
    return Struct(
        (">B" if recipe_id else ">") + "".join(FORMATS[name] for name in types)
    )


@final
class PacketBuffer:
    """Splits received data into packets."""

    def __init__(self) -> None:
        self._received = bytearray()

    def feed(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Yield the type and payload of each complete packet.

        Raises:
            TransportError: If a header contains an impossible size.
        """
        self._received += data
        while len(self._received) >= _HEADER.size:
            size, kind = _HEADER.unpack_from(self._received)
            if not _HEADER.size <= size <= MAX_PACKET:
                message = f"packet of {size} bytes; need {_HEADER.size} to {MAX_PACKET}"
                raise TransportError(message)
            if len(self._received) < size:
                return
            payload = bytes(self._received[_HEADER.size : size])
            del self._received[:size]
            yield kind, payload
