"""Frames that clients may use: links of the robot, and frames fixed to links."""

from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile
from tf2_msgs.msg import TFMessage

from tool0_ros2 import requests
from tool0_ros2.bridge import ControllerContext
from tool0_ros2.connection import RequestFailedError
from tool0_ros2.control_box import ControlBox
from tool0_ros2.copied import Transform, from_quaternion
from tool0_ros2.kinematics import LinkTree

_LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Frames:
    """Finds poses of frames in the base frame of an arm.

    The frames are links, ``tool0_controller`` and the frames in /tf_static.
    """

    def __init__(self, context: ControllerContext, box: ControlBox) -> None:
        """Subscribe to /tf_static."""
        self._context = context
        names = context.names
        self._tree = tree = LinkTree(context.description["urdf"])
        self._links = {names.frame(link): link for link in tree.links}
        prefix = box.flange.removesuffix("tool0")
        self._links.setdefault(names.frame(f"{prefix}tool0_controller"), box.flange)
        base = f"{prefix}base"
        if base not in tree.links:
            arms = context.connection.call(requests.list_arms())
            base = next(arm["base"] for arm in arms if arm["name"] == box.arm)
        self._base = base
        self._fixed: dict[str, tuple[str, Transform]] = {}
        """Parent frame of each frame, and the frame's pose in the parent frame, by
        frame."""
        self._subscription = context.node.create_subscription(
            TFMessage, "/tf_static", self._take, _LATCHED
        )

    def close(self) -> None:
        self._context.node.destroy_subscription(self._subscription)

    def in_base(self, frame: str) -> Transform:
        """Return the current pose of a frame in the base frame of the arm.

        Raises:
            RequestFailedError: If the frame is not connected to the robot.
        """
        T_link_frame, name, seen = Transform(), frame, {frame}
        while (link := self._links.get(name)) is None:
            parent = self._fixed.get(name)
            if parent is None or parent[0] in seen:
                raise RequestFailedError(
                    "ControlError",
                    f"there is no frame '{frame}' on the robot; use a link, or a frame "
                    "that /tf_static connects with one",
                )
            name = parent[0]
            seen.add(name)
            T_link_frame = parent[1] @ T_link_frame
        snapshot = self._context.connection.call(requests.read_snapshot())
        values = dict(zip(snapshot["joint_names"], snapshot["position"]))
        T_root_base = self._tree.pose(self._base, values)
        return T_root_base.inverse() @ self._tree.pose(link, values) @ T_link_frame

    def _take(self, message: Any) -> None:
        for item in message.transforms:
            place, turn = item.transform.translation, item.transform.rotation
            quat_wxyz = (turn.w, turn.x, turn.y, turn.z)
            if any(quat_wxyz):  # tf2 also ignores frames with a zero quaternion
                pose = from_quaternion((place.x, place.y, place.z), quat_wxyz)
                self._fixed[item.child_frame_id] = item.header.frame_id, pose
