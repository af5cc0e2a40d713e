"""The options of the UR interface, and where it serves each arm."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.errors import ConfigError

MAX_PORT_BASE: Final = 65535 - 63352
"""Largest port base, for which the largest port (the gripper's) is still valid."""
LOOPBACK: Final = ipaddress.ip_network("127.0.0.0/8")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class UrOptions:
    """The UR controller."""

    host: str = "127.0.0.1"
    """Address to listen on; further arms of a cell get the following ones."""
    port_base: int = 0
    """Number added to the ports of a real robot."""
    programs: Path | None = None
    """Folder with the programs that the dashboard server can load."""
    allow_sockets: bool = False
    """Whether URScript programs may connect to other machines."""
    active_gripper: bool = False
    """Whether grippers start activated, as if somebody had done it at the pendant."""

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
        """Whether other machines can reach it."""
        return ipaddress.IPv4Address(self.host) not in LOOPBACK

    def host_of(self, number: int) -> str:
        """Return the address of arm ``number``, from 0.

        0.0.0.0 stands for all interfaces, so only one arm is possible with it.
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
    """Address with the ports of a UR, and its gripper's socket on 63352."""
    modbus_port: int | None = None
    """Modbus port of its gripper at this address; None without one."""
    serial_port: str | None = None
    """File of the serial port with the gripper's Modbus RTU; None without one."""
