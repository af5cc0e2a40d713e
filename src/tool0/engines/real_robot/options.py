"""Options of a real robot: the robot's address and the gripper's connection."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

from tool0.errors import ConfigError

MAX_PORT_BASE: Final = 65535 - 63352
"""Largest port base with which all ports are valid.  The port of the gripper is the
largest port."""
GRIPPER_LINKS: Final = ("urcap", "modbus", "rtu", "none")
"""Kinds of gripper connections: Robotiq's URCap on port 63352, Modbus TCP, Modbus RTU
on a serial port, or none."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RealRobotOptions:
    """Options of the engine ``hardware``."""

    address: str = ""
    """Address of the robot's controller: a host name or an IPv4 address."""
    port_base: int = 0
    """Offset added to a real robot's ports, for a simulated controller."""
    callback_host: str = ""
    """Address at which the robot reaches this machine.  If the address is left out,
    this machine's address in the connection to the robot is used."""
    callback_port: int = 0
    """Port to which tool0's program on the robot connects; 0 selects any free port."""
    gripper: str = ""
    """Connection of the gripper: ``urcap``, ``modbus``, ``modbus:HOST:PORT``,
    ``rtu:/dev/ttyUSB0`` or ``none``.  By default, the URCap is used if the description
    has a gripper."""

    def __post_init__(self) -> None:
        if not self.address:
            raise ConfigError(
                "the engine 'hardware' needs the robot's address: "
                "`tool0 bringup --hardware 192.168.1.10`"
            )
        if not 0 <= self.port_base <= MAX_PORT_BASE:
            raise ConfigError(
                f"the base of the ports must be in [0, {MAX_PORT_BASE}], got "
                f"{self.port_base}"
            )
        kind = self.gripper.partition(":")[0]
        if kind and kind not in GRIPPER_LINKS:
            raise ConfigError(
                f"a gripper is reached by one of {', '.join(GRIPPER_LINKS)}, "
                f"not by '{kind}'"
            )
