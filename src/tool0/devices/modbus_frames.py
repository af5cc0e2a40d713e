"""Modbus for clients and servers: header, checksum, functions and exceptions.

"MODBUS Application Protocol Specification V1.1b3" and "MODBUS Messaging on TCP/IP
Implementation Guide V1.0b", "MODBUS over Serial Line Specification V1.02"
(https://modbus.org).
"""

from __future__ import annotations

import struct
from enum import IntEnum
from functools import cache
from typing import Final

HEADER: Final = struct.Struct(">HHHB")
"""Transaction, protocol (0), length of what follows, and unit, which counts."""
MAX_LENGTH: Final = 254
"""Largest size of the unit and a request or a response together [bytes]."""
ERROR: Final = 0x80
"""Number added to the function of a response that is an exception."""


class ModbusFunction(IntEnum):
    """The functions that are used."""

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
    """Why a request is refused: Modbus's exception codes."""

    ILLEGAL_FUNCTION = 1
    ILLEGAL_ADDRESS = 2
    ILLEGAL_VALUE = 3
    NO_RESPONSE = 11
    """The device behind a gateway does not answer."""


@cache
def _table() -> tuple[int, ...]:
    """Return the checksum's change by each byte."""
    table = []
    for byte in range(256):
        crc = byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
        table.append(crc)
    return tuple(table)


def checksum(data: bytes) -> bytes:
    """Return the CRC-16 of Modbus, low byte first (specification, appendix B)."""
    table, crc = _table(), 0xFFFF
    for byte in data:
        crc = crc >> 8 ^ table[(crc ^ byte) & 0xFF]
    return crc.to_bytes(2, "little")
