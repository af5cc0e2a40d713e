"""Modbus frames for clients and servers: header, checksum, functions and exceptions.

Sources: "MODBUS Application Protocol Specification V1.1b3", "MODBUS Messaging on TCP/IP
Implementation Guide V1.0b" and "MODBUS over Serial Line Specification V1.02"
(https://modbus.org).
"""

from __future__ import annotations

import struct
from enum import IntEnum
from functools import cache
from typing import Final

HEADER: Final = struct.Struct(">HHHB")
"""Header of a frame: transaction, protocol (0), number of remaining bytes including the
unit, and unit."""
MAX_LENGTH: Final = 254
"""Maximum size of the unit and a request or response together [bytes]."""
ERROR: Final = 0x80
"""Value that is added to the function code in an exception response."""


class ModbusFunction(IntEnum):
    """Modbus function codes that tool0 uses."""

    READ_COILS = 1
    READ_DISCRETE_INPUTS = 2
    READ_HOLDING = 3
    READ_INPUT = 4
    WRITE_COIL = 5
    WRITE_ONE = 6
    WRITE_COILS = 15
    WRITE = 16
    READ_AND_WRITE = 23


class Refusal(IntEnum):
    """Reasons to refuse a request, with Modbus's exception codes."""

    ILLEGAL_FUNCTION = 1
    ILLEGAL_ADDRESS = 2
    ILLEGAL_VALUE = 3
    NO_RESPONSE = 11
    """The device behind a gateway did not respond."""


@cache
def _table() -> tuple[int, ...]:
    """Return a table with the change in the checksum for each byte value."""
    table = []
    for byte in range(256):
        crc = byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
        table.append(crc)
    return tuple(table)


def checksum(data: bytes) -> bytes:
    """Return the Modbus CRC-16, low byte first (specification, appendix B)."""
    table, crc = _table(), 0xFFFF
    for byte in data:
        crc = crc >> 8 ^ table[(crc ^ byte) & 0xFF]
    return crc.to_bytes(2, "little")
