"""Joints sent somewhere by name, through the trajectory controllers that claim them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from tool0.control.goal_check import check_position
from tool0.control.joint_trajectory import JointTrajectoryController
from tool0.control.manager import ControllerManager
from tool0.control.spline import MotionPlan
from tool0.errors import ControlError, GoalRejectedError, did_you_mean
from tool0.runtime.joint_motion import plan_motion


def joints_by_controller(
    manager: ControllerManager, positions: Mapping[str, float]
) -> Mapping[str, Mapping[str, float]]:
    """Return the positions of each running trajectory controller's joints.

    Raises:
        ControlError: If no such controller claims a joint.
    """
    trajectory_controllers = {
        status.name: manager.spec(status.name).joints
        for status in manager.list()
        if status.state == "running"
        and isinstance(manager.running(status.name), JointTrajectoryController)
    }
    owners = {
        joint: name
        for name, joints in trajectory_controllers.items()
        for joint in joints
    }
    found: dict[str, dict[str, float]] = {}
    for joint, position in positions.items():
        if joint not in owners:
            raise ControlError(
                f"no running JointTrajectoryController claims joint '{joint}', so "
                "nothing moves; start one that does, or leave the joint out"
            )
        found.setdefault(owners[joint], {})[joint] = position
    return found


def planned_motion(
    controller: JointTrajectoryController,
    positions: Mapping[str, float],
    *,
    speed: float,
    now: float,
) -> MotionPlan:
    """Return a smooth motion from what the controller wants now to ``positions``.

    Its other joints go on to where they are going, or stay.

    Args:
        controller: Whose joints; it is only asked.
        positions: Joint → where to [rad | m].
        speed: Part of each joint's largest velocity.
        now: Simulated time of the coming update [s].

    Raises:
        GoalRejectedError: If a joint is not the controller's, or a position is out of
            its limits.
        ControlError: If ``speed`` is out of range.
    """
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
    targets = []
    going_to = controller.setpoint().target()
    for joint, end in zip(spec.joint_models, going_to, strict=True):
        if joint.name in positions:
            position = positions[joint.name]
            check_position(joint, position, f"a motion of '{spec.name}'")
            targets.append(position)
        else:
            targets.append(joint.limits.clamp(end))  # it may stand beyond them
    start = controller.query_state(now)
    return plan_motion(spec.joint_models, start, targets, speed=speed)
