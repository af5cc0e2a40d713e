"""The topic of a controller that forwards commands."""

from collections.abc import Sequence
from typing import Any

from rclpy.qos import QoSProfile
from std_msgs.msg import Float64MultiArray

from tool0_ros2 import requests
from tool0_ros2.bridge import ControllerContext, Update
from tool0_ros2.connection import RequestFailedError


class ForwardCommandPart:
    """Topic ``~/commands``, with one number for each joint."""

    def __init__(self, context: ControllerContext) -> None:
        self._context = context
        self._subscription = context.node.create_subscription(
            Float64MultiArray, "~/commands", self._take, QoSProfile(depth=10)
        )

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        """Publish nothing, because forwarding controllers have no state topic."""

    def close(self) -> None:
        self._context.node.destroy_subscription(self._subscription)

    def _take(self, message: Any) -> None:
        context = self._context
        try:
            context.connection.post(
                requests.command_joints(
                    controller=context.name, values=list(message.data)
                )
            )
        except RequestFailedError as error:
            context.report.error(f"commands: {context.names.text(error)}")
