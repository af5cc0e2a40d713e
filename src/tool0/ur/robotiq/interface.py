"""All interfaces of a gripper in one object."""

from __future__ import annotations

import contextlib
import logging
from pathlib import Path
from typing import final

from tool0.protocol.address import folders, socket_path
from tool0.ur.robotiq.gripper import RobotiqGripper
from tool0.ur.robotiq.modbus_rtu import ModbusRtu
from tool0.ur.robotiq.modbus_tcp import ModbusTcp
from tool0.ur.robotiq.urcap import UrcapSocket

logger = logging.getLogger(__name__)


@final
class RobotiqInterface:
    """The URCap's socket, Modbus TCP, and a serial port with Modbus RTU."""

    def __init__(self, gripper: RobotiqGripper, serial_port: Path) -> None:
        """Prepare the interfaces; ``serial_port`` is the file that clients open."""
        self.serial_port: Path | None = serial_port
        """File of the serial port; None if it could not be created."""
        self._gripper = gripper
        self.modbus_tcp = ModbusTcp(gripper)
        self._socket = UrcapSocket(gripper)
        self._modbus_rtu = ModbusRtu(gripper, serial_port)
        self._stack = contextlib.AsyncExitStack()

    async def start(self, host: str, port_base: int) -> None:
        """Open all interfaces; raise TransportError if a port is in use."""
        self._stack.push_async_callback(self._gripper.close)
        for server in (self._socket, self.modbus_tcp):
            self._stack.push_async_callback(server.close)
            await server.start(host, port_base)
        self._stack.callback(self._modbus_rtu.close)
        try:
            self._modbus_rtu.open()
        except OSError as error:  # a container may have no pseudo-terminals
            self.serial_port = None
            logger.warning("no serial port for the gripper: %s", error)

    async def close(self) -> None:
        """Close all interfaces; the fingers complete their motion."""
        await self._stack.aclose()


def serial_port_path(bringup: str, arm: str) -> Path:
    """Return the path of a gripper's serial port, next to the bring-up's socket."""
    sockets = (socket_path(folder, bringup) for folder in folders())
    found = next(path for path in sockets if path.exists())
    return found.with_name(f"{bringup}-{arm}-gripper")
