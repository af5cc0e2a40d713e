"""A node of the controller manager that uses simulated time without a clock."""

from typing import Any

from rclpy.node import Node

from tool0_ros2.parameters import to_parameters

USE_SIM_TIME = "use_sim_time"
_CLOCK = "/clock"


class SimulatedNode(Node):  # type: ignore[misc]  # rclpy has no types
    """A node whose parameter ``use_sim_time`` is true, as in gz_ros2_control.

    The states already contain stamps, so the node does not subscribe to /clock.
    With rclpy's own subscription, every node of the manager would receive all clock
    messages.
    """

    def __init__(
        self,
        name: str,
        *,
        root: str,
        ros: Any,
        values: dict[str, Any],
        **options: Any,
    ) -> None:
        """Create the node in the namespace ``root``.

        Args:
            name: Name of the node.
            root: The node's namespace; empty if the node has no namespace.
            ros: An rclpy.Context.
            values: Values of the node's parameters.
            options: Options of rclpy.Node.
        """
        super().__init__(
            name,
            namespace=root or "/",
            context=ros,
            use_global_arguments=False,
            parameter_overrides=to_parameters({USE_SIM_TIME: True, **values}),
            **options,
        )

    def create_subscription(
        self, msg_type: Any, topic: str, *args: Any, **options: Any
    ) -> Any:
        """Subscribe to a topic unless it is the clock."""
        if topic == _CLOCK:
            return None
        return super().create_subscription(msg_type, topic, *args, **options)
