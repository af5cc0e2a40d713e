"""/gazebo/model_states and /gazebo/link_states, while somebody listens."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

from tool0.description.forward_kinematics import FrameMotion
from tool0.interfaces.ros1.gazebo.messages import GazeboMessages
from tool0.interfaces.ros1.gazebo.world import GazeboWorld, WorldView
from tool0.interfaces.ros1.node import RosNode
from tool0.sensing.snapshot import Snapshot


@final
class GazeboTopics:
    """Publishes every snapshot, as gazebo_ros every step."""

    def __init__(self, node: RosNode, world: GazeboWorld) -> None:
        from gazebo_msgs.msg import LinkStates, ModelStates

        self._world = world
        self._messages = GazeboMessages()
        self._models = node.publisher(f"{node.options.node}/model_states", ModelStates)
        self._links = node.publisher(f"{node.options.node}/link_states", LinkStates)

    def publish(self, snapshot: Snapshot) -> None:
        """Tell where everything is, if somebody wants to know."""
        view = WorldView(self._world, snapshot)
        if self._models.get_num_connections():
            self._publish(self._models, view.models())
        if self._links.get_num_connections():
            self._publish(self._links, view.links())

    def restart(self) -> None:
        """Forget nothing: nothing here knows the time."""

    def close(self) -> None:
        """Publish no more."""
        self._models.unregister()
        self._links.unregister()

    def _publish(self, publisher: Any, motions: Mapping[str, FrameMotion]) -> None:
        publisher.publish(
            name=list(motions),
            pose=[self._messages.pose(motion.pose) for motion in motions.values()],
            twist=[self._messages.twist(motion) for motion in motions.values()],
        )
