"""Converts between ROS messages and tool0's values: poses, twists, trajectories.

The functions import the message classes when they are called, after
``import_messages``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from tool0.description.forward_kinematics import FrameMotion
from tool0.description.transform import Transform, from_quaternion
from tool0.errors import ControlError
from tool0.protocol.goals import Tolerance
from tool0.protocol.trajectories import JointsMotion, TrajectoryPoint

Message = Any
"""An instance of a class that ROS generates without type annotations."""

MAX_VALUE = 1e6
"""Largest accepted absolute value of a coordinate or velocity [m, m/s, rad/s]."""


def pose_message(pose: Transform) -> Message:
    """Return a pose as a geometry_msgs/Pose."""
    from geometry_msgs.msg import Point, Pose, Quaternion

    w, x, y, z = pose.quat_wxyz
    return Pose(Point(*pose.position), Quaternion(x, y, z, w))


def twist_message(motion: FrameMotion) -> Message:
    """Return a motion as a geometry_msgs/Twist."""
    from geometry_msgs.msg import Twist, Vector3

    return Twist(Vector3(*motion.linear), Vector3(*motion.angular))


def transform_message(header: Message, child_frame_id: str, pose: Transform) -> Message:
    """Return the pose of a child frame as a geometry_msgs/TransformStamped."""
    from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
    from geometry_msgs.msg import Transform as TransformMessage

    w, x, y, z = pose.quat_wxyz
    transform = TransformMessage(Vector3(*pose.position), Quaternion(x, y, z, w))
    return TransformStamped(header, child_frame_id, transform)


def to_transform(pose: Message) -> Transform:
    """Convert a geometry_msgs/Pose.

    A zero quaternion means no rotation, as in Gazebo.

    Raises:
        ControlError: If a value is not finite or too large.
    """
    point, quaternion = pose.position, pose.orientation
    position = to_vector("position", point)
    quat_wxyz = quaternion.w, quaternion.x, quaternion.y, quaternion.z
    if not math.isfinite(math.hypot(*quat_wxyz)):
        raise ControlError(f"the orientation must be finite, got wxyz {quat_wxyz}")
    is_zero = not any(quat_wxyz)
    return from_quaternion(position, (1.0, 0.0, 0.0, 0.0) if is_zero else quat_wxyz)


def to_motion(pose: Message, twist: Message) -> FrameMotion:
    """Return a geometry_msgs/Pose and Twist as a motion.

    The function raises the same exceptions as ``to_transform``.
    """
    return FrameMotion(
        pose=to_transform(pose),
        linear=to_vector("linear velocity", twist.linear),
        angular=to_vector("angular velocity", twist.angular),
    )


def to_vector(what: str, vector: Message) -> tuple[float, float, float]:
    """Return a geometry_msgs/Vector3 or Point as a tuple.

    The function raises the same exceptions as ``to_transform``.
    """
    return _checked(what, (vector.x, vector.y, vector.z))


def _checked(
    what: str, values: tuple[float, float, float]
) -> tuple[float, float, float]:
    if not all(abs(value) <= MAX_VALUE for value in values):
        raise ControlError(
            f"each part of the {what} must be finite and at most {MAX_VALUE:g}, "
            f"got {values}"
        )
    return values


def to_points(points: Sequence[Message]) -> tuple[TrajectoryPoint, ...]:
    """Return trajectory_msgs/JointTrajectoryPoints as values."""
    return tuple(
        TrajectoryPoint(
            positions=point.positions,
            velocities=point.velocities or None,
            accelerations=point.accelerations or None,
            time_from_start=point.time_from_start.to_sec(),
        )
        for point in points
    )


def to_tolerances(tolerances: Sequence[Message]) -> dict[str, Tolerance]:
    """Return control_msgs/JointTolerances as values, by joint."""
    return {
        item.name: Tolerance(item.position, item.velocity, item.acceleration)
        for item in tolerances
    }


def point_message(motion: JointsMotion) -> Message:
    """Return a motion as a trajectory_msgs/JointTrajectoryPoint."""
    from rospy import Duration
    from trajectory_msgs.msg import JointTrajectoryPoint

    return JointTrajectoryPoint(
        positions=motion.positions,
        velocities=motion.velocities,
        accelerations=motion.accelerations,
        time_from_start=Duration.from_sec(motion.time_from_start),
    )
