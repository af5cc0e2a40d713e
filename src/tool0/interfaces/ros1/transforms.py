"""/tf and /tf_static: by robot_state_publisher if it is installed, otherwise by us."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Mapping
from typing import Any, final

from tf2_msgs.msg import TFMessage

from tool0.api.robot import Robot
from tool0.control.joint_state import PublishRate
from tool0.description.forward_kinematics import joint_transform
from tool0.description.model import Joint
from tool0.installation.child_process import ChildProcess
from tool0.installation.ros1.library import find_node
from tool0.interfaces.ros1.messages import Message, transform_message
from tool0.interfaces.ros1.node import RosNode
from tool0.interfaces.ros1.sensors import camera_transforms
from tool0.sensing.snapshot import Snapshot

logger = logging.getLogger(__name__)

NAME = "robot_state_publisher"
_CHECK_RATE = 1.0
"""Checks whether the child process is alive [Hz] of simulated time."""
_GRACE = 5.0
"""For the child process to end by itself [wall s]."""


@final
class RobotStatePublisher:
    """The frames of links and cameras.

    The real robot_state_publisher runs as a child process.  Where it is not installed,
    or once it has ended, our own kinematics publish the same frames.
    """

    def __init__(self, node: RosNode, robot: Robot) -> None:
        self._node, self._robot = node, robot
        self._joints = robot.description.model.joints
        self._rate = PublishRate(node.options.tf_pub_rate)
        self._check_rate = PublishRate(_CHECK_RATE)
        self._static = node.publisher("/tf_static", TFMessage, latch=True)
        self._publisher: Any = None
        self._program = find_node(f"{NAME}/{NAME}")
        self._child: ChildProcess | None = None
        if self._program is None:
            self._take_over()
        else:
            self._static.publish(camera_transforms(node, robot))
            self._child = self._start()

    def publish(self, snapshot: Snapshot) -> None:
        """Publish the frames of movable joints if they are due; watch the child."""
        child = self._child
        if child is None:
            if self._rate.is_due(snapshot.time):
                names, values = snapshot.joint_names, snapshot.position
                position = dict(zip(names, values, strict=True))
                movable = (joint for joint in self._joints if joint.is_movable)
                self._publisher.publish(
                    self._transforms(movable, position, snapshot.time)
                )
        elif self._check_rate.is_due(snapshot.time) and child.exit_status is not None:
            logger.warning(
                "robot_state_publisher ended with status %d; tool0 publishes /tf "
                "from now on.  Its last output:\n%s",
                child.exit_status,
                child.last_output(),
            )
            self._child = None
            self._take_over()

    def register_again(self) -> None:
        """Restart the child: nodes of roscpp do not notice that the master is new."""
        if self._child is not None:
            old, self._child = self._child, self._start()
            old.close()

    def close(self) -> None:
        """End the child, and unregister the topics."""
        if self._child is not None:
            self._child.close()
        if self._publisher is not None:
            self._publisher.unregister()
        self._static.unregister()

    def _start(self) -> ChildProcess:
        node, options = self._node, self._node.options
        name = node.name(NAME)
        node.master.call("setParam", f"{name}/publish_frequency", options.tf_pub_rate)
        node.master.call("setParam", f"{name}/tf_prefix", node.tf_prefix)
        environment = {**os.environ, "ROS_NAMESPACE": options.root or "/"}
        command = [str(self._program), f"__name:={NAME}"]
        return ChildProcess(command, environment=environment, grace=_GRACE)

    def _take_over(self) -> None:
        """Publish the fixed frames, and from now on the movable ones."""
        node, robot = self._node, self._robot
        fixed = (joint for joint in self._joints if not joint.is_movable)
        transforms = self._transforms(fixed, {}, robot.time)
        self._static.publish(transforms + camera_transforms(node, robot))
        self._publisher = node.publisher("/tf", TFMessage, queue_size=100)

    def _transforms(
        self, joints: Iterable[Joint], position: Mapping[str, float], time: float
    ) -> list[Message]:
        frame = self._node.frame
        return [
            transform_message(
                self._node.header(time, frame(joint.parent)),
                frame(joint.child),
                joint_transform(joint, position),
            )
            for joint in joints
        ]
