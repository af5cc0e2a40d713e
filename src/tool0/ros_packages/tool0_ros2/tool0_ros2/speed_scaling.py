"""The topic of UR's speed_scaling_state_broadcaster."""

from collections.abc import Sequence

from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from tool0_ros2.bridge import ControllerContext, Rate, Update
from tool0_ros2.control_box import ControlBox

DEFAULT_RATE = 100.0
"""Default rate at which the topic is published [Hz]."""


class SpeedScalingPart:
    """Topic ``~/speed_scaling`` with the speed scaling factor of trajectories [%]."""

    def __init__(self, context: ControllerContext) -> None:
        self._context = context
        parameters = context.parameters
        prefix = parameters.get("tf_prefix") or context.names.prefix
        self._box = ControlBox(context, prefix)
        self._rate = Rate(parameters.get("state_publish_rate", DEFAULT_RATE))
        self._publisher = context.node.create_publisher(
            Float64, "~/speed_scaling", QoSProfile(depth=10)
        )

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        if self._rate.is_due(update.time) and self._publisher.get_subscription_count():
            factor = self._box.state(update)["speed_scaling"]
            self._publisher.publish(Float64(data=100.0 * factor))

    def close(self) -> None:
        self._context.node.destroy_publisher(self._publisher)
