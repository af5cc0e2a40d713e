"""The process of the UR interface, which starts and stops together with a robot."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Final, final

from tool0.errors import TransportError
from tool0.server.companion import START_TIMEOUT, Companion
from tool0.ur.options import UrArm, UrOptions

if TYPE_CHECKING:
    from tool0.protocol.channel import Connected

MODULE: Final = "tool0.ur"


@final
class UrController(Companion):
    """Context manager that presents a robot's arms as UR control boxes.

    Each arm has an address with the ports of a real robot: RTDE, the dashboard server,
    the primary, secondary and real-time interfaces, and the gripper's ports. A separate
    process serves the ports.
    """

    title, kind, unavailable = "UR", "interface", TransportError

    def __init__(
        self, robot: Connected | str, options: UrOptions | None = None
    ) -> None:
        """Start the process; call ``wait`` to wait until its ports are open.

        Args:
            robot: A robot of this process or of another process, which the caller must
                close after the controller; or the name of a bring-up, which may start
                later.
            options: Addresses and ports.
        """
        self.options = options = options or UrOptions()
        super().__init__(robot, lambda name: _command(name, options), os.environ)

    def wait(self, timeout: float = START_TIMEOUT) -> dict[str, UrArm]:
        """Wait until the ports are open; return the address of each arm.

        Raises:
            TransportError: If a port cannot be opened within ``timeout`` [wall s].
        """
        arms = self._wait_for_report(timeout)["arms"]
        return {name: UrArm(**row) for name, row in arms.items()}


def _command(name: str, options: UrOptions) -> list[str]:
    command = [
        *(sys.executable, "-m", MODULE, "--name", name),
        *("--host", options.host, "--port-base", str(options.port_base)),
    ]
    if options.programs is not None:
        command += ["--programs", str(options.programs)]
    if options.allow_sockets:
        command.append("--allow-sockets")
    if options.active_gripper:
        command.append("--active-gripper")
    return command
