"""Options of the UR interface, and the addresses at which it serves the arms."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.errors import ConfigError

MAX_PORT_BASE: Final = 65535 - 63352
"""Maximum port base, with which the highest port (the gripper's) is still valid."""
LOOPBACK: Final = ipaddress.ip_network("127.0.0.0/8")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class UrOptions:
    """Options of the UR controller."""

    host: str = "127.0.0.1"
    """Address of the first arm to listen on; the other arms get the following
    addresses."""
    port_base: int = 0
    """Number that is added to the port numbers of a real robot."""
    programs: Path | None = None
    """Folder with the programs that the dashboard server can load."""
    allow_sockets: bool = False
    """Whether URScript programs may connect to other machines."""
    active_gripper: bool = False
    """Whether grippers are already activated at the start, as after an activation on
    the pendant."""

    def __post_init__(self) -> None:
        try:
            address = ipaddress.ip_address(self.host)
        except ValueError:
            address = None
        if not isinstance(address, ipaddress.IPv4Address):
            raise ConfigError(
                f"'{self.host}' is not an IPv4 address to listen on, such as 127.0.0.1"
            )
        if not 0 <= self.port_base <= MAX_PORT_BASE:
            raise ConfigError(
                f"the base of the ports must be in [0, {MAX_PORT_BASE}], got "
                f"{self.port_base}: it is added to port numbers up to 63352"
            )
        if self.programs is not None and not self.programs.is_dir():
            raise ConfigError(f"{self.programs} is not a folder with programs")

    @property
    def is_public(self) -> bool:
        """Whether other machines can connect to the interface."""
        return ipaddress.IPv4Address(self.host) not in LOOPBACK

    def host_of(self, number: int) -> str:
        """Return the address of an arm; ``number`` starts at 0.

        The address 0.0.0.0 stands for all interfaces, so it can serve only one arm.
        """
        if number and self.host == "0.0.0.0":
            raise ConfigError(
                "several arms need an address each, and 0.0.0.0 stands for all; "
                "give the address of the first arm"
            )
        return str(ipaddress.IPv4Address(self.host) + number)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class UrArm:
    """Address at which an arm is served as a UR."""

    address: str
    """Address of the UR's ports and of the gripper's socket on port 63352."""
    modbus_port: int | None = None
    """Modbus port of the arm's gripper at this address; None if there is no such
    port."""
    serial_port: str | None = None
    """File of the serial port for the gripper's Modbus RTU; None if there is no such
    port."""
