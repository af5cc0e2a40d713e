"""The topic of UR's freedrive_mode_controller."""

from collections.abc import Sequence
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.qos import QoSProfile
from std_msgs.msg import Bool

from tool0_ros2 import requests
from tool0_ros2.bridge import ControllerContext, Update
from tool0_ros2.control_box import ControlBox
from tool0_ros2.requests import Request


class FreedrivePart:
    """Topic ``~/enable_freedrive_mode``, on which repeated messages free the arm.

    The messages must have the value true.
    """

    def __init__(self, context: ControllerContext) -> None:
        self._context = context
        node, parameters = context.node, context.parameters
        prefix = parameters.get("tf_prefix") or context.names.prefix
        self._arm = ControlBox(context, prefix).arm
        self._timeout = parameters.get("inactive_timeout", 1)
        self._subscription = node.create_subscription(
            Bool, "~/enable_freedrive_mode", self._take, QoSProfile(depth=10)
        )
        # The timer uses wall time, as in UR's driver, because a publisher may not use
        # simulated time.
        self._timer = node.create_timer(
            float(self._timeout),
            self._note_silence,
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )
        self._timer.cancel()
        self._end()  # ends freedrive if an earlier node left it active

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        """Publish nothing, because this controller has no state topic."""

    def close(self) -> None:
        node = self._context.node
        node.destroy_timer(self._timer)
        node.destroy_subscription(self._subscription)
        self._end()

    def _take(self, message: Any) -> None:
        if not message.data:
            self._timer.cancel()
            self._end()
            return
        self._timer.reset()
        self._send(
            requests.start_freedrive(arm=self._arm, controller=self._context.name)
        )

    def _note_silence(self) -> None:
        self._timer.cancel()
        self._context.node.get_logger().info(
            f"freedrive ends: no message came for {self._timeout} s"
        )
        self._end()

    def _end(self) -> None:
        self._send(requests.end_freedrive(arm=self._arm, controller=self._context.name))

    def _send(self, request: Request[None]) -> None:
        future = self._context.connection.submit(request)
        future.add_done_callback(self._log_refusal)

    def _log_refusal(self, future: Any) -> None:
        """Log why a request was refused, unless the controller is inactive."""
        error = future.exception()
        if error is not None and error.kind != "GoalRejectedError":
            text = self._context.names.text(error)
            self._context.report.error(f"enable_freedrive_mode: {text}")
