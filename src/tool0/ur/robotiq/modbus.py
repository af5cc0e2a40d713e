"""Modbus function codes and registers of the gripper, for any transport.

The functions and exceptions follow "MODBUS Application Protocol Specification V1.1b3"
(https://modbus.org). The registers follow Robotiq's instruction manuals.
"""

from __future__ import annotations

import struct
from typing import Final, final

from tool0.devices.modbus_frames import ERROR, ModbusFunction, Refusal
from tool0.devices.robotiq_registers import BLOCK_BYTES, CommandRegisters
from tool0.ur.robotiq.gripper import RobotiqGripper

COMMAND: Final = 1000
"""First command register, 0x03E8."""
STATUS: Final = 2000
"""First status register, 0x07D0."""
REGISTERS: Final = BLOCK_BYTES // 2
"""Number of registers in each block. The last five registers are reserved: reading them
returns 0, and writing to them has no effect."""
MAX_READ: Final = 125
MAX_WRITTEN: Final = 123
MAX_WRITTEN_AND_READ: Final = 121
"""Maximum numbers of registers that the specification allows."""
_FUNCTIONS: Final = {
    *(ModbusFunction.READ_HOLDING, ModbusFunction.READ_INPUT, ModbusFunction.WRITE_ONE),
    *(ModbusFunction.WRITE, ModbusFunction.READ_AND_WRITE),
}
"""Functions that the gripper supports."""
_RANGE, _RANGES = struct.Struct(">HH"), struct.Struct(">HHHH")


class _RefusedError(Exception):
    def __init__(self, refusal: Refusal) -> None:
        self.refusal = refusal


def refusal(function: int, why: Refusal) -> bytes:
    """Return the response that refuses a request."""
    return bytes([function | ERROR, why])


def respond(gripper: RobotiqGripper, request: bytes, *, is_tcp: bool = False) -> bytes:
    """Return the response to a request; both start with a function code.

    Args:
        gripper: The gripper.
        request: Request of at least one byte; the length of the request has not been
            checked.
        is_tcp: Whether the command and status blocks are also available at register 0,
            as in Robotiq's grippers with built-in Modbus TCP.
    """
    function, data = request[0], request[1:]
    try:
        return bytes([function]) + _RegisterFile(gripper, is_tcp=is_tcp).do(
            function, data
        )
    except _RefusedError as error:
        return refusal(function, error.refusal)


@final
class _RegisterFile:
    def __init__(self, gripper: RobotiqGripper, *, is_tcp: bool) -> None:
        self._gripper = gripper
        self._is_tcp = is_tcp

    def do(self, function: int, data: bytes) -> bytes:
        """Return the data of the response; raise an error if the request is refused."""
        match function:
            case ModbusFunction.READ_HOLDING | ModbusFunction.READ_INPUT if (
                len(data) == 4
            ):
                found = self._read(function, *_RANGE.unpack(data))
                return bytes([len(found)]) + found
            case ModbusFunction.WRITE_ONE if len(data) == 4:
                self._write(_RANGE.unpack(data)[0], data[2:])
                return data
            case ModbusFunction.WRITE if len(data) >= 5:
                address, count = _RANGE.unpack(data[:4])
                self._check(count, MAX_WRITTEN, data[4], data[5:])
                self._write(address, data[5:])
                return data[:4]
            case ModbusFunction.READ_AND_WRITE if len(data) >= 9:
                source, wanted, address, count = _RANGES.unpack(data[:8])
                self._check(count, MAX_WRITTEN_AND_READ, data[8], data[9:])
                self._read(function, source, wanted)  # check the range before writing
                self._write(address, data[9:])
                found = self._read(function, source, wanted)
                return bytes([len(found)]) + found
            case _ if function in _FUNCTIONS:
                raise _RefusedError(Refusal.ILLEGAL_VALUE)
            case _:
                raise _RefusedError(Refusal.ILLEGAL_FUNCTION)

    def _read(self, function: int, address: int, count: int) -> bytes:
        if not 1 <= count <= MAX_READ:
            raise _RefusedError(Refusal.ILLEGAL_VALUE)
        command, status = self._gripper.command.encode(), self._gripper.status.encode()
        blocks = {COMMAND: command, STATUS: status}
        if self._is_tcp:
            blocks[0] = status if function == ModbusFunction.READ_INPUT else command
        for start, block in blocks.items():
            if start <= address and address + count <= start + REGISTERS:
                first = 2 * (address - start)
                return block[first : first + 2 * count]
        raise _RefusedError(Refusal.ILLEGAL_ADDRESS)

    def _write(self, address: int, data: bytes) -> None:
        start = 0 if self._is_tcp and address < COMMAND else COMMAND
        first = 2 * (address - start)
        if not 0 <= first <= BLOCK_BYTES - len(data):
            raise _RefusedError(Refusal.ILLEGAL_ADDRESS)
        block = bytearray(self._gripper.command.encode())
        block[first : first + len(data)] = data
        self._gripper.write(CommandRegisters.decode(bytes(block)))

    def _check(self, count: int, most: int, length: int, data: bytes) -> None:
        if not (1 <= count <= most and length == len(data) == 2 * count):
            raise _RefusedError(Refusal.ILLEGAL_VALUE)
