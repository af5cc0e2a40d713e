"""How frames move: pose and velocity at one instant, in plain floats."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

from tool0.description.kinematics import Transform, transforms
from tool0.description.model import Joint, JointType, Pose, RobotModel, Vector3

_STILL: Vector3 = (0.0, 0.0, 0.0)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class FrameMotion:
    """Where a frame is and how it moves, seen from another and in its axes."""

    pose: Transform = field(default_factory=Transform)
    linear: Vector3 = _STILL
    """Velocity of its origin [m/s]."""
    angular: Vector3 = _STILL
    """[rad/s]"""

    def carry(self, fixed: Transform) -> FrameMotion:
        """Return the motion of a frame that sits firmly on this one."""
        pose = self.pose @ fixed
        arm = _difference(pose.position, self.pose.position)
        return FrameMotion(
            pose=pose,
            linear=_sum(self.linear, cross(self.angular, arm)),
            angular=self.angular,
        )

    def seen_from(self, other: FrameMotion) -> FrameMotion:
        """Return this motion relative to that of ``other``, in the axes of ``other``.

        As Gazebo has it: the velocities are subtracted, so that the turning of
        ``other`` does not count.
        """
        back = other.pose.inverse()
        turn = Transform(rotation=back.rotation)
        return FrameMotion(
            pose=back @ self.pose,
            linear=turn.apply(_difference(self.linear, other.linear)),
            angular=turn.apply(_difference(self.angular, other.angular)),
        )

    def placed_in(self, frame: Transform) -> FrameMotion:
        """Return this motion, given in a frame at rest, in the frame around it."""
        turn = Transform(rotation=frame.rotation)
        return FrameMotion(
            pose=frame @ self.pose,
            linear=turn.apply(self.linear),
            angular=turn.apply(self.angular),
        )


def link_motions(
    model: RobotModel, position: Mapping[str, float], velocity: Mapping[str, float]
) -> dict[str, FrameMotion]:
    """Return how every link moves in the root link.

    Args:
        model: The robot.
        position: Joint positions [rad | m] by name, as for ``transforms``.
        velocity: Of the same joints [rad/s | m/s]; mimic joints that are left out
            follow, others stand still.
    """
    poses = transforms(model, position)
    found = {model.root: FrameMotion()}
    for joint in model.joints:
        parent = found[joint.parent]
        pose = poses[joint.child]
        arm = _difference(pose.position, parent.pose.position)
        linear = _sum(parent.linear, cross(parent.angular, arm))
        angular = parent.angular
        rate = _velocity(joint, velocity)
        if rate:  # the axis is the same before and after the joint's own turn
            axis = Transform(rotation=pose.rotation).apply(joint.axis)
            own = (rate * axis[0], rate * axis[1], rate * axis[2])
            if joint.type is JointType.PRISMATIC:
                linear = _sum(linear, own)
            else:
                angular = _sum(angular, own)
        found[joint.child] = FrameMotion(pose=pose, linear=linear, angular=angular)
    return found


def from_quaternion(position: Sequence[float], quat_wxyz: Sequence[float]) -> Transform:
    """Return the pose with a quaternion of any length above 0."""
    px, py, pz = position
    length = math.hypot(*quat_wxyz)
    w, x, y, z = (part / length for part in quat_wxyz)
    return Transform(
        position=(px, py, pz),
        rotation=(
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        ),
    )


def to_pose(transform: Transform) -> Pose:
    """Return ``transform`` as URDF's ``<origin>`` would write it."""
    (xx, _, _), (yx, yy, yz), (zx, zy, zz) = transform.rotation
    flat = math.hypot(xx, yx)
    if flat > 1e-9:  # [1] above that, roll and yaw can be told from each other
        rpy = (math.atan2(zy, zz), math.atan2(-zx, flat), math.atan2(yx, xx))
    else:
        rpy = (math.atan2(-yz, yy), math.atan2(-zx, flat), 0.0)
    return Pose(xyz=transform.position, rpy=rpy)


def _velocity(joint: Joint, velocity: Mapping[str, float]) -> float:
    if joint.name in velocity:
        return velocity[joint.name]
    if joint.mimic is None:
        return 0.0
    return joint.mimic.multiplier * velocity.get(joint.mimic.joint, 0.0)


def _sum(a: Vector3, b: Vector3) -> Vector3:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _difference(a: Vector3, b: Vector3) -> Vector3:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def cross(a: Vector3, b: Vector3) -> Vector3:
    """Return the vector product of a and b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
