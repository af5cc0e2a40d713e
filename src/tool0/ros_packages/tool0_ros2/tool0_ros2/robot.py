"""The whole robot of a namespace: its description and its frames."""

from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from tool0_ros2.bridge import Context, Rate, Update
from tool0_ros2.copied import joint_transform
from tool0_ros2.kinematics import Joint, read_joints
from tool0_ros2.messages import fill_frame

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Quality of service with which late subscribers also receive the last message."""
PUBLISHER = "robot_state_publisher"
STATIC_FRAMES = "/tf_static"


class RobotPart:
    """Topics ``/robot_description``, ``/tf`` and ``/tf_static``.

    Frames are published while a joint_state_broadcaster is active, as with a
    robot_state_publisher.  Frames are not published while a robot_state_publisher runs.
    """

    def __init__(self, context: Context, urdf: str, tf_rate: float) -> None:
        """Publish the description ``urdf``.  Publish frames at ``tf_rate`` [Hz]."""
        self._context = context
        names, node = context.names, context.node
        joints = [joint for joint in read_joints(urdf) if joint.parent and joint.child]
        self._movable = [joint for joint in joints if joint.is_movable]
        self._fixed = [joint for joint in joints if not joint.is_movable]
        children = {joint.child for joint in joints}
        self._root = next((j.parent for j in joints if j.parent not in children), "")
        self._message = TFMessage(transforms=list(map(self._transform, self._movable)))
        self._rate = Rate(tf_rate)
        self.has_joint_states = False
        """Whether a joint_state_broadcaster is active."""
        self._frames: Any = None
        self._static: Any = None
        self._topic = names.topic("robot_description")
        self._description = node.create_publisher(String, self._topic, LATCHED)
        self._description.publish(String(data=urdf))
        self._start()

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        frames = self._frames
        is_on = frames is not None and self.has_joint_states
        if not (is_on and self._rate.is_due(update.time)):
            return
        names, index, position = self._context.names, update.index, update.position
        values = {names.to_ros(name): position[k] for name, k in index.items()}
        for item, joint in zip(self._message.transforms, self._movable):
            item.header.stamp = update.stamp
            frame, transform = joint_transform(joint, values), item.transform
            fill_frame(transform.translation, transform.rotation, frame)
        frames.publish(self._message)

    def close(self) -> None:
        self._stop()
        self._context.node.destroy_publisher(self._description)

    def look_for_publisher(self) -> None:
        """Publish frames only while there is no robot_state_publisher.

        The list of nodes cannot be used, because in rmw_fastrtps it may permanently
        contain a node whose process has ended.  The publishers of an ended node
        disappear.
        """
        node, root = self._context.node, self._context.names.root or "/"
        is_there = any(
            (item.node_name, item.node_namespace) == (PUBLISHER, root)
            for item in node.get_publishers_info_by_topic(STATIC_FRAMES)
        )
        if is_there and self._frames is not None:
            node.get_logger().info(f"a {PUBLISHER} runs: it publishes the frames")
            self._stop()
        elif not is_there and self._frames is None:
            self._start()

    def look_for_twin(self) -> None:
        """Warn if another bring-up uses the same names in this domain."""
        node = self._context.node
        own = node.get_name(), node.get_namespace()
        named_alike = [
            item
            for item in node.get_publishers_info_by_topic(self._topic)
            if (item.node_name, item.node_namespace) == own
        ]
        if len(named_alike) > 1:
            self._context.report.warning(
                f"another bring-up publishes {self._topic} in this domain: requests "
                "and goals reach either; give one of them --ros2-ns or --domain"
            )

    def _start(self) -> None:
        node = self._context.node
        self._static = node.create_publisher(TFMessage, STATIC_FRAMES, LATCHED)
        fixed = list(map(self._transform, self._fixed))
        if self._root and self._context.names.tf_prefix:
            fixed.append(self._place_in_cell())
        self._static.publish(TFMessage(transforms=fixed))
        self._frames = node.create_publisher(TFMessage, "/tf", QoSProfile(depth=100))

    def _stop(self) -> None:
        frames, self._frames = self._frames, None
        static, self._static = self._static, None
        for publisher in (frames, static):
            if publisher is not None:
                self._context.node.destroy_publisher(publisher)

    def _place_in_cell(self) -> TransformStamped:
        """Return the transform from the cell's root to the robot's prefixed root."""
        names, message = self._context.names, TransformStamped()
        message.header.frame_id = self._root
        message.child_frame_id = names.frame(names.to_model(self._root))
        return message

    def _transform(self, joint: Joint) -> TransformStamped:
        frame = self._context.names.frame
        names = self._context.names
        message = TransformStamped()
        message.header.frame_id = frame(names.to_model(joint.parent))
        message.child_frame_id = frame(names.to_model(joint.child))
        transform = message.transform
        frame_at_zero = joint_transform(joint, {})
        fill_frame(transform.translation, transform.rotation, frame_at_zero)
        return message
