"""Modbus TCP: frames with a header instead of an address and a checksum.

The frames follow "MODBUS Messaging on TCP/IP Implementation Guide V1.0b"
(https://modbus.org).
"""

from __future__ import annotations

import socket
from typing import Final, final

from tool0.devices.modbus_frames import HEADER, MAX_LENGTH, Refusal
from tool0.ur.listening import REQUEST_COST, Peer, Port
from tool0.ur.robotiq.gripper import RobotiqGripper
from tool0.ur.robotiq.modbus import refusal, respond

PORT: Final = 502
UNPRIVILEGED_PORT: Final = 1502
"""Port that is used if the user has no permission to listen on ports below 1024."""


@final
class ModbusTcp:
    """The gripper behind a Modbus gateway, which responds to every unit number."""

    def __init__(self, gripper: RobotiqGripper) -> None:
        self._gripper = gripper
        self._port = Port("Modbus", self._serve)

    @property
    def number(self) -> int:
        """Number of the port after it has been opened."""
        return self._port.number

    async def start(self, host: str, port_base: int) -> None:
        """Open the port; raise TransportError if the port is in use."""
        port = PORT + port_base
        if not _may_listen(host, port):
            port = UNPRIVILEGED_PORT + port_base
        await self._port.listen(host, port)

    async def close(self) -> None:
        """Close the port and its connections."""
        await self._port.close()

    async def _serve(self, peer: Peer) -> None:
        while True:
            header = await peer.reader.readexactly(HEADER.size)
            transaction, protocol, length, unit = HEADER.unpack(header)
            if protocol != 0 or not 2 <= length <= MAX_LENGTH:
                return  # not Modbus, so the start of the next frame is unknown
            request = await peer.reader.readexactly(length - 1)
            if self._gripper.is_powered:
                response = respond(self._gripper, request, is_tcp=True)
            else:
                response = refusal(request[0], Refusal.NO_RESPONSE)
            size = len(response) + 1
            peer.send(HEADER.pack(transaction, 0, size, unit) + response)
            await peer.account.pay(REQUEST_COST)


def _may_listen(host: str, port: int) -> bool:
    """Return whether this user has permission to listen on a port."""
    with socket.socket() as attempt:
        try:
            attempt.bind((host, port))
        except PermissionError:
            return False
        except OSError:
            pass  # the call that opens the port reports other errors
    return True
