"""A node of the controller manager's: in simulated time, without a clock of its own."""

from typing import Any

from rclpy.node import Node

from tool0_ros2.parameters import to_parameters

USE_SIM_TIME = "use_sim_time"
_CLOCK = "/clock"


class SimulatedNode(Node):  # type: ignore[misc]  # rclpy has no types
    """A node whose parameter ``use_sim_time`` is true, as in gz_ros2_control.

    Its stamps come with the states, so it does not listen to /clock: rclpy would have
    every such node take each message of it.
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
        """Create it in the namespace ``root``.

        Args:
            name: Name of the node.
            root: Its namespace; empty for none.
            ros: An rclpy.Context.
            values: Values of parameters.
            options: Options of rclpy's nodes.
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
        """Subscribe to a topic, unless rclpy wants the clock."""
        if topic == _CLOCK:
            return None
        return super().create_subscription(msg_type, topic, *args, **options)
