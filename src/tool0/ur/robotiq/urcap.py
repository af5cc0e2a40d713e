"""The URCap's socket, with ASCII lines such as ``SET POS 255 GTO 1`` and ``GET OBJ``.

The protocol is the one that the URCap's clients expect (cmodel_urcap.py of
cambel/robotiq, ur_rtde's robotiq_gripper.cpp, and the URScript functions ``rq_…`` of
Robotiq's URCap):

* The answer to ``SET VAR n [VAR n …]`` is ``ack`` without a newline.
* The answer to ``GET VAR`` with a newline is ``VAR n`` and a newline.
* The answer to ``GET VAR`` without a newline, which the URCap's functions send, is only
  the value with a fixed width: ``3``, ``00``, ``255``.
* The answer to any other command is ``?``. Without power, the answer is always ``?``.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable
from typing import Final, final

from tool0.devices.robotiq_registers import CommandRegisters, StatusRegisters
from tool0.ur.listening import REQUEST_COST, Peer, Port
from tool0.ur.robotiq.gripper import RobotiqGripper

PORT: Final = 63352
SLAVE: Final = 9
"""The gripper's address on the control box's bus."""
MAX_LINE: Final = 1024
"""Maximum length of a command, and maximum amount of data that is processed before
other tasks can run [bytes]."""
NEWLINE_TIMEOUT: Final = 0.03
"""Time after which a command without a newline is considered complete [wall s]."""

_WRITABLE: Final[dict[str, tuple[str, Callable[[int], int | bool]]]] = {
    "ACT": ("activate", bool),
    "GTO": ("go_to", bool),
    "ATR": ("release", bool),
    "ARD": ("release_opening", lambda value: not value),
    "ADR": ("release_opening", bool),
    "POS": ("position", int),
    "SPE": ("speed", int),
    "FOR": ("force", int),
}
"""Variables, each with its command register and the conversion to the register's value.
ARD 0 opens the gripper in the URCap's functions and in ur_rtde, unlike the register
rARD. In robotiq_gripper.py, the variable ARD is named ADR."""
_READABLE: Final[
    dict[str, tuple[int, Callable[[CommandRegisters, StatusRegisters], int]]]
] = {
    "ACT": (1, lambda _, status: status.is_activated),
    "GTO": (1, lambda _, status: status.goes_to),
    "ATR": (1, lambda command, _: command.release),
    "ARD": (1, lambda command, _: not command.release_opening),
    "ADR": (1, lambda command, _: command.release_opening),
    "SPE": (3, lambda command, _: command.speed),
    "FOR": (3, lambda command, _: command.force),
    "PRE": (3, lambda _, status: status.request),
    "POS": (3, lambda _, status: status.position),
    "STA": (1, lambda _, status: status.activation),
    "OBJ": (1, lambda _, status: status.object_status),
    "FLT": (2, lambda _, status: status.fault),
    "COU": (3, lambda _, status: status.current),
}
"""Variables, each with the number of digits in an answer without a name, and a function
that returns the value."""
_SLAVE_VARIABLE: Final = "SID"
_BYTE = re.compile(r"\d{1,3}", re.ASCII)
_WITHOUT_NEWLINE = re.compile(rb"\s*GET +[A-Z]{3}")


def answer(gripper: RobotiqGripper, line: str, *, is_short: bool = False) -> str:
    """Return the answer to a command; the answer to an empty line is empty.

    Args:
        gripper: The gripper.
        line: The command.
        is_short: Whether the answer contains only the value.
    """
    match line.split():
        case []:
            return ""
        case ["GET", name]:
            value = _value(gripper, name, is_short=is_short)
            return value if is_short else f"{name} {value}\n"
        case ["SET", *words]:
            return _set(gripper, words)
        case _:
            return "?"


def _value(gripper: RobotiqGripper, name: str, *, is_short: bool) -> str:
    if not gripper.is_powered:
        return "?"
    if name == _SLAVE_VARIABLE:
        return f"[{SLAVE}]"
    if name not in _READABLE:
        return "?"
    digits, get = _READABLE[name]
    value = int(get(gripper.command, gripper.status))
    return f"{value:0{digits}}" if is_short else str(value)


def _set(gripper: RobotiqGripper, words: list[str]) -> str:
    """Write all variables together, or no variable if any of them is invalid."""
    names, values = words[::2], words[1::2]
    if not (names and len(names) == len(values) and gripper.is_powered):
        return "?"
    fields: dict[str, int | bool] = {}
    for name, text in zip(names, values, strict=True):
        if not _BYTE.fullmatch(text) or (value := int(text)) > 255:
            return "?"
        if name in _WRITABLE:
            field, convert = _WRITABLE[name]
            fields[field] = convert(value)
        elif name != _SLAVE_VARIABLE:
            return "?"
    if fields:
        gripper.change(**fields)
    return "ack"


@final
class UrcapSocket:
    """The URCap's port, at which all clients share one gripper."""

    def __init__(self, gripper: RobotiqGripper) -> None:
        self._gripper = gripper
        self._port = Port("gripper", self._serve, limit=MAX_LINE)

    async def start(self, host: str, port_base: int) -> None:
        """Open the port; raise TransportError if the port is in use."""
        await self._port.listen(host, PORT + port_base)
        self._gripper.address = (host, PORT + port_base)

    async def close(self) -> None:
        """Close the port and its connections."""
        await self._port.close()

    async def _serve(self, peer: Peer) -> None:
        rest = b""
        while True:
            is_whole = _WITHOUT_NEWLINE.fullmatch(rest) is not None
            try:
                data = await asyncio.wait_for(
                    peer.reader.read(MAX_LINE), NEWLINE_TIMEOUT if is_whole else None
                )
            except asyncio.TimeoutError:
                peer.send(self._answer(rest, is_short=True))
                rest = b""
                continue
            if not data:
                return
            *lines, rest = (rest + data).split(b"\n")
            peer.send(b"".join(self._answer(line) for line in lines))
            if len(rest) > MAX_LINE:
                peer.send(b"?")
                await peer.close()
                return
            await peer.account.pay(len(lines) * REQUEST_COST)

    def _answer(self, line: bytes, *, is_short: bool = False) -> bytes:
        text = line.decode("ascii", errors="replace")
        return answer(self._gripper, text, is_short=is_short).encode(errors="replace")
