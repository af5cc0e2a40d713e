"""Targets of planned motions, as joint positions of the arms."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from tool0.description.model import Joint, RobotModel
from tool0.description.transform import Pose, to_transform
from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import ArmChain, Array
from tool0.kinematics.inverse import InverseKinematics
from tool0.planning.planner import windings
from tool0.protocol.planning import PlanTarget
from tool0.simulation.tool_poses import pose_in_base, tool_in_flange

ROUNDING: Final = 1e-3
"""Distance by which a target may be beyond a joint's limit [rad]."""
_FREE_TURNS: Final = 24
"""Number of rotation angles about a free axis that are tried."""


def goals_of(
    model: RobotModel,
    chain: ArmChain,
    target: PlanTarget,
    positions: Mapping[str, float],
) -> Array:
    """Return all joint positions of an arm that reach a target, shape (n, 6).

    Args:
        model: The robot.
        chain: The arm, with the applicable limits.
        target: Joint positions or a pose.
        positions: Positions of all joints [rad | m]; commanded positions are used where
            they are available.

    Raises:
        UnreachableError: If the target cannot be reached; the message contains the
            reason.
        ControlError: If the target is invalid, or is not a target of the arm.
    """
    if (target.pose is None) == (not target.positions):
        raise ControlError("a target needs either joint positions or a pose")
    start = np.array([positions[name] for name in chain.joint_names])
    if target.pose is None:
        return _joint_goal(chain.joints, start, target.positions)[None]
    kinematics = InverseKinematics(chain)
    found = []
    T_base_tool = pose_in_base(model, chain, target, positions)
    T_tool_tip = np.linalg.inv(tool_in_flange(model, chain, target))
    for turn in _turns(target.free_axis):
        T_base_tip = T_base_tool @ turn @ T_tool_tip
        found += [
            windings(q, chain.joints, start)
            for q in kinematics.postures(T_base_tip, start)
        ]
    goals = np.concatenate([np.empty((0, len(start))), *found])
    if not len(goals):
        # raises an error with the reason
        kinematics.solutions(T_base_tool @ T_tool_tip, start)
        raise UnreachableError("no posture of the target is within the limits")
    return goals


def _joint_goal(
    joints: Sequence[Joint], start: Array, positions: Mapping[str, float]
) -> Array:
    names = [joint.name for joint in joints]
    for name, position in positions.items():
        if name not in names:
            raise ControlError(
                f"'{name}' is not a joint of the arm: {', '.join(names)}"
            )
        limits = joints[names.index(name)].limits
        if not limits.lower - ROUNDING <= position <= limits.upper + ROUNDING:
            raise UnreachableError(
                f"joint '{name}' cannot be at {position:.4g} rad: its limits are "
                f"[{limits.lower:.4g}, {limits.upper:.4g}]"
            )
    given = zip(names, start, strict=True)
    return np.array([positions.get(name, here) for name, here in given])


def combined(goals: Sequence[Array], start: Array) -> Array:
    """Return joint goals of several arms, combined from each arm's nearest goals."""
    if len(goals) == 1:
        return goals[0]
    most = max(2, int(512 ** (1.0 / len(goals))))
    starts = np.split(start, np.cumsum([each.shape[1] for each in goals])[:-1])
    rows = [
        each[np.abs(each - here).max(axis=1).argsort(kind="stable")[:most]]
        for each, here in zip(goals, starts, strict=True)
    ]
    return np.array([np.concatenate(each) for each in itertools.product(*rows)])


def within(joint: Joint, wanted: tuple[float, float] | None) -> Joint:
    """Return a copy of a joint with narrower limits [rad | m]."""
    if wanted is None:
        return joint
    lower = max(wanted[0], joint.limits.lower)
    upper = min(wanted[1], joint.limits.upper)
    if not lower < upper:
        raise ControlError(
            f"joint_ranges: [{wanted[0]:g}, {wanted[1]:g}] leaves joint '{joint.name}' "
            f"nothing of [{joint.limits.lower:.4g}, {joint.limits.upper:.4g}]"
        )
    return replace(joint, limits=replace(joint.limits, lower=lower, upper=upper))


def _turns(axis: str | None) -> list[Array]:
    """Return the rotations to try about a tool axis, each of shape (4, 4)."""
    if axis is None:
        return [np.eye(4)]
    turns = []
    for angle in np.linspace(0.0, 2.0 * math.pi, _FREE_TURNS, endpoint=False).tolist():
        about = {"x": (angle, 0.0, 0.0), "y": (0.0, angle, 0.0)}
        rpy = about.get(axis, (0.0, 0.0, angle))
        turns.append(to_transform(Pose(rpy=rpy)).matrix)
    return turns
