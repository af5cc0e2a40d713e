"""The process of the UR interface: it starts with a robot, and ends with it."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
from typing import TYPE_CHECKING, Final, final

from tool0.errors import TransportError
from tool0.interfaces.companion import START_TIMEOUT, Companion, served_name
from tool0.interfaces.ur.options import UrArm, UrOptions

if TYPE_CHECKING:
    from tool0.api.robot import Robot

logger = logging.getLogger(__name__)

MODULE: Final = "tool0.interfaces.ur"


@final
class UrController(contextlib.AbstractContextManager["UrController"]):
    """Presents a robot as Universal Robots' control boxes do.  A context manager.

    Each arm has an address with the ports of a real robot: RTDE, dashboard server,
    primary, secondary and real-time interface, and those of its gripper.  They are
    served by a process of their own, which starts again when it dies.
    """

    def __init__(self, robot: Robot | str, options: UrOptions | None = None) -> None:
        """Start the process; ``wait`` waits until its ports are open.

        Args:
            robot: A robot of this process or another one, which the caller closes
                after this; or the name of a bring-up, which may start later.
            options: Addresses and ports.
        """
        self.options = options or UrOptions()
        with contextlib.ExitStack() as stack:
            name = served_name(robot, "ur", stack)
            self._companion = Companion(
                "UR",
                "interface",
                _command(name, self.options),
                {**os.environ, "PYTHONUNBUFFERED": "1"},
                logger=logger,
                unavailable=TransportError,
            )
            self._stack = stack.pop_all()

    def wait(self, timeout: float = START_TIMEOUT) -> dict[str, UrArm]:
        """Wait until the ports are open; return where each arm is served.

        Raises:
            TransportError: If a port cannot be listened on, or not within ``timeout``
                [wall s].
        """
        arms = self._companion.wait(timeout)["arms"]
        return {name: UrArm(**row) for name, row in arms.items()}

    @property
    def pid(self) -> int | None:
        """The process id; None while it does not run."""
        return self._companion.pid

    def close(self) -> None:
        """End the process; closing twice is allowed."""
        self._companion.close()
        self._stack.close()

    def __exit__(self, *_: object) -> None:
        self.close()


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
