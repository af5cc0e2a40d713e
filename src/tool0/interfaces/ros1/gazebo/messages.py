"""Poses, twists and states as geometry_msgs and gazebo_msgs say them ↔ as we do."""

from __future__ import annotations

import math
from typing import final

from tool0.description.forward_kinematics import FrameMotion
from tool0.description.transform import Transform, from_quaternion
from tool0.errors import ControlError
from tool0.interfaces.ros1.conversions import Message

FARTHEST = 1e6
"""[m], [m/s] and [rad/s]: physics goes astray with figures far beyond it."""


@final
class GazeboMessages:
    """Converts, once the classes that ROS generates can be imported."""

    def __init__(self) -> None:
        from geometry_msgs.msg import Point, Pose, Quaternion, Twist, Vector3

        self._pose, self._point, self._quaternion = Pose, Point, Quaternion
        self._twist, self._vector = Twist, Vector3

    def pose(self, pose: Transform) -> Message:
        """Return a geometry_msgs/Pose."""
        w, x, y, z = pose.quat_wxyz
        return self._pose(self._point(*pose.position), self._quaternion(x, y, z, w))

    def twist(self, motion: FrameMotion) -> Message:
        """Return a geometry_msgs/Twist."""
        return self._twist(self._vector(*motion.linear), self._vector(*motion.angular))


def to_transform(pose: Message) -> Transform:
    """Return a geometry_msgs/Pose; a quaternion of zeros is no turn, as in Gazebo.

    Raises:
        ControlError: If it is not finite, or beyond all bounds.
    """
    place, turn = pose.position, pose.orientation
    position = _checked("position", (place.x, place.y, place.z))
    quat_wxyz = turn.w, turn.x, turn.y, turn.z
    if not math.isfinite(math.hypot(*quat_wxyz)):
        raise ControlError(f"the orientation must be finite, got wxyz {quat_wxyz}")
    is_none = not any(quat_wxyz)
    return from_quaternion(position, (1.0, 0.0, 0.0, 0.0) if is_none else quat_wxyz)


def to_motion(pose: Message, twist: Message) -> FrameMotion:
    """Return a pose and a geometry_msgs/Twist; raises ControlError as for a pose."""
    linear, angular = twist.linear, twist.angular
    return FrameMotion(
        pose=to_transform(pose),
        linear=_checked("linear velocity", (linear.x, linear.y, linear.z)),
        angular=_checked("angular velocity", (angular.x, angular.y, angular.z)),
    )


def _checked(
    what: str, values: tuple[float, float, float]
) -> tuple[float, float, float]:
    if not all(abs(value) <= FARTHEST for value in values):
        raise ControlError(
            f"each part of the {what} must be finite and at most {FARTHEST:g}, "
            f"got {values}"
        )
    return values
