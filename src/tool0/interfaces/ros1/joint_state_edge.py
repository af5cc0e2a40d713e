"""A JointStateController in ROS: /joint_states."""

from __future__ import annotations

from typing import final

from tool0.api.controller import ControllerHandle
from tool0.control.joint_state import JointStateSpec
from tool0.control.publish_rate import PublishRate
from tool0.interfaces.ros1.node import RosNode
from tool0.sensing.snapshot import Snapshot


@final
class JointStateEdge:
    """The topic of one controller, while it runs."""

    def __init__(
        self, node: RosNode, spec: JointStateSpec, controller: ControllerHandle
    ) -> None:
        from sensor_msgs.msg import JointState

        del controller  # it takes no commands
        self._node = node
        self._spec = spec
        self._message = JointState
        self._rate = PublishRate(spec.publish_rate)
        self._publisher = node.publisher("joint_states", JointState, queue_size=100)

    def publish(self, snapshot: Snapshot) -> None:
        """Publish the joints, if it is time to."""
        if not self._rate.is_due(snapshot.time):
            return
        joints = self._spec.message(
            snapshot.joint_names, snapshot.position, snapshot.velocity, snapshot.effort
        )
        self._publisher.publish(
            self._message(
                header=self._node.header(snapshot.time),
                name=joints.names,
                position=joints.position,
                velocity=joints.velocity,
                effort=joints.effort,
            )
        )

    def restart(self) -> None:
        """Forget nothing: the rate sees that time went back."""

    def close(self) -> None:
        """Present it no longer."""
        self._publisher.unregister()
