"""Positions of all joints from those of some."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tool0.description.forward_kinematics import joint_position
from tool0.description.model import RobotModel
from tool0.errors import LimitsError, ModelError, did_you_mean


def joint_positions(
    model: RobotModel, given: Mapping[str, float], otherwise: Sequence[float]
) -> list[float]:
    """Return every movable joint's position [rad | m], shape (n_joints,).

    Args:
        model: The robot; the order is that of its ``movable_joints``.
        given: Positions of some joints, by name.
        otherwise: Positions of the rest; mimic joints follow their master.

    Raises:
        ModelError: For a joint that the robot lacks or that cannot be placed.
        LimitsError: For a position outside the joint's limits, or not a number.
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
