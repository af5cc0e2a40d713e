"""Paths for trajectory controllers: whose joints they move, and their form there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tool0.control.controller import TrajectoryFollower
from tool0.control.manager import ControllerManager
from tool0.control.position_limits import check_position
from tool0.control.spline import Motion, MotionPlan
from tool0.description.model import Joint
from tool0.errors import ControlError, GoalRejectedError, did_you_mean
from tool0.motion.joint import plan_cubic, plan_joints
from tool0.motion.path import Path
from tool0.protocol.controllers import Role, why_not_driven
from tool0.protocol.trajectories import TrajectoryPoint


def joints_by_controller(
    manager: ControllerManager, positions: Mapping[str, float]
) -> Mapping[str, Mapping[str, float]]:
    """Return the positions of each running trajectory controller's joints.

    Raises:
        ControlError: If no such controller drives a joint.
    """
    owners = {
        joint: status.name
        for status in manager.list()
        if status.is_running and status.role is Role.TRAJECTORY
        for joint in status.joints
    }
    found: dict[str, dict[str, float]] = {}
    for joint, position in positions.items():
        if joint not in owners:
            raise ControlError(why_not_driven(manager.list(), [joint]))
        found.setdefault(owners[joint], {})[joint] = position
    return found


def planned_path(
    controller: TrajectoryFollower,
    positions: Mapping[str, float],
    *,
    speed: float,
    now: float,
) -> Path:
    """Return a smooth motion from the controller's present setpoint to ``positions``.

    Its other joints continue their motion, or stay.

    Args:
        controller: Whose joints; it does not change.
        positions: Joint → target [rad | m].
        speed: Fraction of each joint's largest velocity.
        now: Simulated time of the coming update [s].

    Raises:
        GoalRejectedError: If a joint is not the controller's, or a position is out of
            its limits.
        ControlError: If ``speed`` is out of range.
    """
    joints = _checked(controller, positions, f"a motion of '{controller.spec.name}'")
    ends = controller.setpoint().target()
    # The present end of a joint that is left out may be beyond its limits.
    targets = [
        positions.get(joint.name, joint.limits.clamp(end))
        for joint, end in zip(joints, ends, strict=True)
    ]
    return plan_joints(joints, controller.query_state(now), targets, speed=speed)


def timed_path(
    controller: TrajectoryFollower,
    positions: Mapping[str, float],
    *,
    duration: float,
    now: float,
) -> Path:
    """Return a cubic from the controller's present setpoint to rest at ``positions``.

    Its other joints keep their setpoints.

    Args:
        controller: Whose joints; it does not change.
        positions: Joint → target [rad | m].
        duration: Duration of the motion [s].
        now: Simulated time of the coming update [s].

    Raises:
        GoalRejectedError: If a joint is not the controller's, or a position is out of
            its limits.
        ControlError: If a joint would exceed its velocity limit.
    """
    joints = _checked(controller, positions, "the motion")
    start = controller.query_state(now)
    targets = [
        positions.get(joint.name, q)
        for joint, q in zip(joints, start.positions, strict=True)
    ]
    return plan_cubic(joints, start, targets, duration)


def _checked(
    controller: TrajectoryFollower, positions: Mapping[str, float], what: str
) -> Sequence[Joint]:
    """Return a controller's joints, which can reach ``positions``."""
    spec = controller.spec
    for name, position in positions.items():
        if name not in spec.joints:
            raise GoalRejectedError(
                f"joint '{name}' is not one of '{spec.name}'"
                + did_you_mean(name, spec.joints),
                GoalRejectedError.INVALID_JOINTS,
            )
        if not math.isfinite(position):
            raise GoalRejectedError(
                f"position {position} for joint '{name}'; it must be finite"
            )
    for joint in spec.joint_models:
        if joint.name in positions:
            check_position(joint, positions[joint.name], what)
    return spec.joint_models


def motion_plan(path: Path) -> MotionPlan:
    """Return a path as a plan that starts with the setpoint."""
    times, columns = path.times[1:].tolist(), [path.positions, path.velocities]
    if path.accelerations is not None:
        columns.append(path.accelerations)
    return [
        list(zip(times, map(Motion, *motion), strict=True))
        for motion in zip(*(column[1:].T.tolist() for column in columns), strict=True)
    ]


def trajectory_points(path: Path) -> list[TrajectoryPoint]:
    """Return a path as the points of a goal that starts with the setpoint."""
    n_points, qdd = len(path.times) - 1, path.accelerations
    accelerations = [None] * n_points if qdd is None else qdd[1:].tolist()
    columns = (path.positions[1:], path.velocities[1:], path.times[1:])
    q, qd, times = (column.tolist() for column in columns)
    return list(map(TrajectoryPoint, q, qd, accelerations, times))
