"""A controller that takes numbers, in ROS: its topic ``command``."""

from __future__ import annotations

from typing import final

from tool0.api.controller import ControllerHandle
from tool0.control.forward_command import ForwardCommandSpec
from tool0.interfaces.ros1.node import RosNode
from tool0.sensing.snapshot import Snapshot


@final
class ForwardEdge:
    """The topic of one controller: Float64, or Float64MultiArray for a group."""

    def __init__(
        self, node: RosNode, spec: ForwardCommandSpec, controller: ControllerHandle
    ) -> None:
        from std_msgs.msg import (
            Float64,
            Float64MultiArray,
        )

        kind = Float64MultiArray if "JointGroup" in spec.type else Float64
        self._subscriber = node.subscriber(
            f"{spec.name}/command",
            kind,
            lambda message: controller.command(message.data),
        )

    def publish(self, snapshot: Snapshot) -> None:
        """Publish nothing: such a controller has no state topic here."""

    def restart(self) -> None:
        """Forget nothing: there are no times."""

    def close(self) -> None:
        """Present it no longer."""
        self._subscriber.unregister()
