"""Forward kinematics with plain floats: joint positions, link poses and velocities.

``joint_tree`` computes the kinematics of many joint positions at the same time, and
``flat_frames`` does so for the tick.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Final, TypeVar, final

from tool0.description.model import Joint, JointType, RobotModel
from tool0.description.transform import (
    Pose,
    Transform,
    Vector3,
    add,
    cross,
    rotation_about,
    subtract,
    to_transform,
)
from tool0.errors import LimitsError, ModelError, did_you_mean

if TYPE_CHECKING:  # NumPy is slow to import
    import numpy as np
    from numpy.typing import NDArray

T = TypeVar("T", float, "NDArray[np.float64]")
TURNING: Final = frozenset({JointType.REVOLUTE, JointType.CONTINUOUS})
_ZERO: Vector3 = (0.0, 0.0, 0.0)


def link_poses(
    model: RobotModel, position: Mapping[str, float] | None = None
) -> dict[str, Transform]:
    """Return the pose of every link in the root link.

    A joint that is missing from ``position`` [rad | m] is at 0, or follows its master
    joint.

    Raises:
        ModelError: If ``position`` contains a joint that the robot does not have.
    """
    given = position or {}
    _check_names(model, given)
    found = {model.root: Transform()}
    for joint in model.joints:
        found[joint.child] = found[joint.parent] @ joint_transform(joint, given)
    return found


def link_pose(
    model: RobotModel,
    position: Mapping[str, float],
    link: str,
    relative_to: str | None = None,
) -> Transform:
    """Return the pose of ``link`` in ``relative_to``; None means the root link."""
    _check_names(model, position)
    T_root_link = _above(model, position, link)
    if relative_to is None:
        return T_root_link
    return _above(model, position, relative_to).inverse() @ T_root_link


def _above(model: RobotModel, position: Mapping[str, float], link: str) -> Transform:
    """Return the pose of ``link`` in the root, computed from the joints above it."""
    joints, name = [], model.link(link).name
    while (joint := model.parent_joint.get(name)) is not None:
        joints.append(joint)
        name = joint.parent
    pose = Transform()
    for joint in reversed(joints):
        pose = pose @ joint_transform(joint, position)
    return pose


def _check_names(model: RobotModel, position: Mapping[str, float]) -> None:
    for name in sorted(position.keys() - model.joint_by_name.keys()):
        model.joint(name)  # raises


def joint_transform(joint: Joint, position: Mapping[str, float]) -> Transform:
    """Return the pose of the joint's child link in its parent link.

    ``position`` has the same meaning as for ``link_poses``.  Planar and floating joints
    always have position 0.
    """
    at_zero = _at_zero(joint.origin)
    if joint.type is JointType.PRISMATIC:
        q, (x, y, z) = joint_position(joint, position), joint.axis
        return at_zero @ Transform(position=(q * x, q * y, q * z))
    if joint.type in TURNING:
        turn = rotation_about(joint.axis, joint_position(joint, position))
        return at_zero @ Transform(rotation=turn)
    return at_zero


@lru_cache(maxsize=1024)  # the origins of the joints of some robots, which are constant
def _at_zero(origin: Pose) -> Transform:
    return to_transform(origin) @ Transform()  # without negative zeros


def joint_position(joint: Joint, position: Mapping[str, T]) -> T | float:
    """Return the position of ``joint``.

    The result is the given position, the position from the mimic relation, or 0.

    Positions are numbers or arrays.
    """
    mimic = joint.mimic
    if mimic is None or joint.name in position:
        return position.get(joint.name, 0.0)
    return mimic.multiplier * position.get(mimic.joint, 0.0) + mimic.offset


def joint_positions(
    model: RobotModel, given: Mapping[str, float], otherwise: Sequence[float]
) -> list[float]:
    """Return the positions of the movable joints [rad | m], shape (n_joints,).

    Args:
        model: The robot.  The positions are in the order of the robot's
            ``movable_joints``.
        given: Positions of some joints, by name.
        otherwise: Positions used for the joints that are not in ``given``.  The values
            for mimic joints are ignored, since mimic joints follow their master joints.

    Raises:
        ModelError: If a joint is unknown or its position cannot be determined.
        LimitsError: If a position is outside the joint's limits or is not a number.
    """
    joints = {joint.name: joint for joint in model.movable_joints}
    for name, value in given.items():
        if name not in joints:
            raise ModelError(f"unknown joint '{name}'{did_you_mean(name, set(joints))}")
        joint = joints[name]
        if joint.mimic is not None:
            raise ModelError(
                f"joint '{name}' mimics '{joint.mimic.joint}'; place that one instead"
            )
        if not joint.limits.lower <= value <= joint.limits.upper:
            raise LimitsError(
                f"position {value} of joint '{name}' is outside "
                f"[{joint.limits.lower}, {joint.limits.upper}]"
            )
    positions = {**dict(zip(joints, otherwise, strict=True)), **given}
    independent = {
        name: positions[name] for name in joints if joints[name].mimic is None
    }
    return [joint_position(joint, independent) for joint in joints.values()]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class FrameMotion:
    """Pose and velocity of a frame relative to a reference frame.

    Vectors are in the axes of the reference frame.
    """

    pose: Transform = field(default_factory=Transform)
    linear: Vector3 = _ZERO
    """Linear velocity of the frame's origin [m/s]."""
    angular: Vector3 = _ZERO
    """Angular velocity of the frame [rad/s]."""

    def carry(self, fixed: Transform) -> FrameMotion:
        """Return the motion of a frame whose pose in this frame is always ``fixed``."""
        pose = self.pose @ fixed
        arm = subtract(pose.position, self.pose.position)
        return FrameMotion(
            pose=pose,
            linear=add(self.linear, cross(self.angular, arm)),
            angular=self.angular,
        )

    def relative_to(self, other: FrameMotion) -> FrameMotion:
        """Return this motion relative to ``other``, in the axes of ``other``.

        The velocities are subtracted, as in Gazebo.  The rotation of ``other`` does
        not contribute to the relative velocity.
        """
        T_other_reference = other.pose.inverse()
        return FrameMotion(
            pose=T_other_reference @ self.pose,
            linear=T_other_reference.rotate(subtract(self.linear, other.linear)),
            angular=T_other_reference.rotate(subtract(self.angular, other.angular)),
        )

    def placed_in(self, frame: Transform) -> FrameMotion:
        """Return this motion, given in the static ``frame``, in that frame's parent."""
        return FrameMotion(
            pose=frame @ self.pose,
            linear=frame.rotate(self.linear),
            angular=frame.rotate(self.angular),
        )


def link_motions(
    model: RobotModel, position: Mapping[str, float], velocity: Mapping[str, float]
) -> dict[str, FrameMotion]:
    """Return the motion of every link relative to the root link.

    Positions [rad | m] and velocities [rad/s | m/s] are given by joint name, as for
    ``link_poses``.  If no velocity is given, a mimic joint follows its master joint,
    and any other joint is at rest.
    """
    found = {model.root: FrameMotion()}
    for joint in model.joints:
        motion = found[joint.parent].carry(joint_transform(joint, position))
        mimic = joint.mimic
        if mimic is None or joint.name in velocity:
            rate = velocity.get(joint.name, 0.0)
        else:
            rate = mimic.multiplier * velocity.get(mimic.joint, 0.0)
        if rate:  # the joint's motion does not change the direction of its axis
            x, y, z = motion.pose.rotate(joint.axis)
            own = (rate * x, rate * y, rate * z)
            if joint.type is JointType.PRISMATIC:
                motion = replace(motion, linear=add(motion.linear, own))
            else:
                motion = replace(motion, angular=add(motion.angular, own))
        found[joint.child] = motion
    return found
