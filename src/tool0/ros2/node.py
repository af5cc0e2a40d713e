"""The process of the ROS 2 node, which starts and ends together with a robot.

The node is the ROS package ``tool0_ros2`` in ``ros_packages``.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, final

from tool0.errors import RosUnavailableError
from tool0.installation.ros2.installation import NODE_FOLDER, Ros2, find_ros2
from tool0.ros2.options import Ros2Options
from tool0.server.companion import START_TIMEOUT, Companion

if TYPE_CHECKING:
    from tool0.protocol.channel import Connected


@final
class Ros2Node(Companion):
    """Context manager that presents a robot in ROS 2 as ros2_control does.

    The node runs in a separate process, with the Python interpreter of a ROS 2
    installation.
    """

    title, kind, unavailable = "ROS 2", "node", RosUnavailableError

    def __init__(
        self, robot: Connected | str, options: Ros2Options | None = None
    ) -> None:
        """Start the node.  Call ``wait`` to wait until the node is ready.

        Args:
            robot: A robot in this process or another one, or the name of a bring-up.
                The caller must close the robot after the node.  A bring-up may start
                after the node.
            options: Namespace, domain and rates.

        Raises:
            RosUnavailableError: If ROS 2 is not installed.
        """
        self.options = options = options or Ros2Options()
        ros2 = find_ros2()
        if ros2 is None:
            raise RosUnavailableError(
                "there is no ROS 2 on this machine: source one, or run "
                "`tool0 ros2 install`"
            )
        self.ros2 = ros2
        super().__init__(
            robot,
            lambda name: _command(ros2, name, options),
            _environment(ros2, options),
        )

    @property
    def domain(self) -> int:
        """The node's ROS_DOMAIN_ID."""
        return int(self._environment.get("ROS_DOMAIN_ID") or 0)

    def wait(self, timeout: float = START_TIMEOUT) -> str:
        """Wait until the node is ready, and return its full name.

        Raises:
            RosUnavailableError: If the node could not start within ``timeout`` [wall
                s].
        """
        node: str = self._wait_for_report(timeout)["node"]
        return node


def _environment(ros2: Ros2, options: Ros2Options) -> dict[str, str]:
    environment = dict(ros2.environment)
    paths = [str(NODE_FOLDER), environment.get("PYTHONPATH", "")]
    environment["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
    if options.domain is not None:
        environment["ROS_DOMAIN_ID"] = str(options.domain)
    return environment


def _command(ros2: Ros2, name: str, options: Ros2Options) -> list[str]:
    return [
        *(str(ros2.python), "-m", NODE_FOLDER.name),
        *("--name", name, "--ns", options.ns, "--wait"),
        *("--tf-rate", repr(options.tf_rate)),
        *("--camera-rate", repr(options.camera_rate)),
    ]
