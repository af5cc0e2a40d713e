"""/tf and /tf_static: by robot_state_publisher where there is one, else by us."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import Any, Protocol, final

from tool0.api.robot import Robot
from tool0.control.publish_rate import PublishRate
from tool0.description.forward_kinematics import joint_transform
from tool0.description.model import Joint
from tool0.description.transform import Transform
from tool0.installation.child_process import ChildProcess
from tool0.installation.ros1.library import find_node
from tool0.interfaces.ros1.camera_edge import camera_transforms
from tool0.interfaces.ros1.node import Part, RosNode
from tool0.sensing.snapshot import Snapshot

logger = logging.getLogger(__name__)

NAME = "robot_state_publisher"
_WATCH_RATE = 1.0  # [Hz] of simulated time
_GRACE = 5.0  # [wall s] that it has to end by itself


class Transforms(Part, Protocol):
    """What publishes the robot's frames."""

    def register_again(self) -> None:
        """Appear under a master that is new."""


def transforms_of(node: RosNode, robot: Robot) -> Transforms:
    """Return what publishes the robot's frames."""
    program = find_node(f"{NAME}/{NAME}")
    if program is None:
        return OwnTransforms(node, robot)
    return TheirTransforms(node, robot, program)


@final
class TheirTransforms:
    """The real robot_state_publisher, as a child; if it ends, ours go on."""

    def __init__(self, node: RosNode, robot: Robot, program: Path) -> None:
        from tf2_msgs.msg import TFMessage

        self._node, self._robot = node, robot
        self._own: OwnTransforms | None = None
        self._rate = PublishRate(_WATCH_RATE)
        self._program = program
        self._static = node.publisher("/tf_static", TFMessage, latch=True)
        self._static.publish(TFMessage(camera_transforms(node, robot)))
        self._child = self._start()

    def _start(self) -> ChildProcess:
        node, options = self._node, self._node.options
        place = node.name(NAME)
        node.master.call("setParam", f"{place}/publish_frequency", options.tf_pub_rate)
        node.master.call("setParam", f"{place}/tf_prefix", node.frame_prefix)
        environment = {**os.environ, "ROS_NAMESPACE": options.root or "/"}
        command = [str(self._program), f"__name:={NAME}"]
        return ChildProcess(command, environment=environment, grace=_GRACE)

    def register_again(self) -> None:
        """Start it anew: nodes of roscpp do not notice that the master is another."""
        old, self._child = self._child, self._start()
        old.close()

    def publish(self, snapshot: Snapshot) -> None:
        """See whether it lives."""
        if self._own is not None:
            self._own.publish(snapshot)
        elif self._rate.is_due(snapshot.time) and self._child.exit_status is not None:
            logger.warning(
                "robot_state_publisher ended with status %d; /tf is published by "
                "tool0 from now on.  It said last:\n%s",
                self._child.exit_status,
                self._child.last_output(),
            )
            self._own = OwnTransforms(self._node, self._robot)

    def restart(self) -> None:
        """Forget nothing: the rates see that time went back."""

    def close(self) -> None:
        """End it."""
        self._child.close()
        self._static.unregister()


@final
class OwnTransforms:
    """The same frames, by our own kinematics."""

    def __init__(self, node: RosNode, robot: Robot) -> None:
        from geometry_msgs.msg import TransformStamped
        from tf2_msgs.msg import TFMessage

        self._node = node
        joints = robot.description.model.joints
        self._moving = [joint for joint in joints if joint.is_movable]
        self._stamped, self._message = TransformStamped, TFMessage
        self._rate = PublishRate(node.options.tf_pub_rate)
        prefix = node.frame_prefix
        self._prefix = f"{prefix}/" if prefix else ""
        self._publisher = node.publisher("/tf", TFMessage, queue_size=100)
        self._static = node.publisher("/tf_static", TFMessage, latch=True)
        now = robot.time
        self._static.publish(
            TFMessage(
                [
                    self._transform(joint, joint_transform(joint, {}), now)
                    for joint in joints
                    if not joint.is_movable
                ]
                + camera_transforms(node, robot)
            )
        )

    def publish(self, snapshot: Snapshot) -> None:
        """Publish the frames of movable joints, if it is time to."""
        if not self._rate.is_due(snapshot.time):
            return
        position = dict(zip(snapshot.joint_names, snapshot.position, strict=True))
        self._publisher.publish(
            self._message(
                [
                    self._transform(
                        joint, joint_transform(joint, position), snapshot.time
                    )
                    for joint in self._moving
                ]
            )
        )

    def register_again(self) -> None:
        """Do nothing: the node does it."""

    def restart(self) -> None:
        """Forget nothing: the rate sees that time went back."""

    def close(self) -> None:
        """Publish no more."""
        self._publisher.unregister()
        self._static.unregister()

    def _transform(self, joint: Joint, pose: Transform, time: float) -> Any:
        message = self._stamped(header=self._node.header(time))
        message.header.frame_id = self._prefix + joint.parent
        message.child_frame_id = self._prefix + joint.child
        place, turn = message.transform.translation, message.transform.rotation
        place.x, place.y, place.z = pose.position
        turn.w, turn.x, turn.y, turn.z = pose.quat_wxyz
        return message
