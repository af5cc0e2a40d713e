"""A probe of ``tool0 doctor``: whether ``tool0 bringup --ur`` can start here."""

from __future__ import annotations

import socket
from typing import Final

from tool0.installation.doctor.report import ProbeResult
from tool0.installation.machine import (
    Machine,
    pip_install_command,
    python_package_version,
)
from tool0.interfaces.ur.options import UrOptions

PORTS: Final = (29999, 30001, 30002, 30003, 30004, 63352)
"""Those that every client of a UR or its gripper expects."""


def ur(_: Machine) -> list[ProbeResult]:
    """Return whether URScript can be read, and whether the ports are free."""
    host = UrOptions().host
    used = [str(port) for port in PORTS if not _is_free(host, port)]
    ports = f"the ports of a UR at {host} are free"
    if used:
        ports = (
            f"in use at {host}: {', '.join(used)}; choose others by --ur-host or "
            "--ur-port-base"
        )
    version = python_package_version("lark")
    if version is None:
        found = f"no lark, which reads URScript; without it, ur_rtde works; {ports}"
        return [ProbeResult("ur", "missing", found, pip_install_command("lark"))]
    return [ProbeResult("ur", "ready", f"lark {version}; {ports}")]


def _is_free(host: str, port: int) -> bool:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError:
            return False
    return True
