"""The topic and the frame of a pose_broadcaster."""

from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import PoseStamped, TransformStamped
from rclpy.qos import QoSProfile
from tf2_msgs.msg import TFMessage

from tool0_ros2.bridge import ControllerContext, Rate, Update
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.control_box import flange_of
from tool0_ros2.copied import Transform
from tool0_ros2.kinematics import LinkTree
from tool0_ros2.messages import fill_frame


class PosePart:
    """Topic ``~/pose`` with the pose of an arm's flange, and its TF frame.

    The pose is given in the link ``frame_id``.
    """

    def __init__(self, context: ControllerContext) -> None:
        self._context = context
        names, parameters = context.names, context.parameters
        self._tree = LinkTree(context.description["urdf"])
        frame = parameters.get("frame_id") or names.to_model("base")
        self._flange = flange_of(context, parameters.get("pose_name") or names.prefix)
        if frame not in self._tree.links:
            raise RequestFailedError(
                "ConfigError",
                f"frame_id: the robot has no link '{names.to_ros(frame)}'",
            )
        self._link = frame
        node = context.node
        self._message = PoseStamped()
        self._message.header.frame_id = names.frame(frame)
        self._poses = node.create_publisher(PoseStamped, "~/pose", QoSProfile(depth=10))
        self._frames: Any = None
        child = parameters.get("tf.child_frame_id") or parameters.get("pose_name")
        if parameters.get("tf.enable", True) and child:
            self._transform = TransformStamped()
            self._transform.header.frame_id = self._message.header.frame_id
            self._transform.child_frame_id = names.frame(child)
            self._rate = Rate(parameters.get("tf_publish_rate") or float("inf"))
            self._frames = node.create_publisher(
                TFMessage, "/tf", QoSProfile(depth=100)
            )

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        is_read = self._poses.get_subscription_count() > 0
        frames = self._frames
        is_heard = frames is not None and frames.get_subscription_count() > 0
        is_due = is_heard and self._rate.is_due(update.time)
        if not (is_read or is_due):
            return
        pose = self._pose(update)
        if is_read:
            message = self._message
            message.header.stamp = update.stamp
            fill_frame(message.pose.position, message.pose.orientation, pose)
            self._poses.publish(message)
        if is_due:
            item = self._transform
            item.header.stamp = update.stamp
            fill_frame(item.transform.translation, item.transform.rotation, pose)
            frames.publish(TFMessage(transforms=[item]))

    def close(self) -> None:
        node = self._context.node
        node.destroy_publisher(self._poses)
        if self._frames is not None:
            node.destroy_publisher(self._frames)

    def _pose(self, update: Update) -> Transform:
        position, index = update.position, update.index
        values = {name: position[k] for name, k in index.items()}
        T_root_link = self._tree.pose(self._link, values)
        return T_root_link.inverse() @ self._tree.pose(self._flange, values)
