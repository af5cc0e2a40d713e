"""Checks of a trajectory for a ROS 2 controller, and its tolerances.

The checks use the messages of joint_trajectory_controller in ROS 2, in the same order.
Unlike joint_trajectory_controller, the checks also reject numbers that are not finite,
duplicate joints, and positions beyond a joint's limits.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from typing import NamedTuple

from tool0.control.goal_motion import check_finite
from tool0.control.tolerances import JointTolerances, TrajectoryTolerances, as_tolerance
from tool0.control.trajectory import TrajectoryGoal
from tool0.errors import GoalRejectedError, did_you_mean
from tool0.protocol.goals import Tolerance, ToleranceOverride
from tool0.protocol.trajectories import TrajectoryPoint

logger = logging.getLogger(__name__)

EPSILON = 1.1920929e-07
"""Tolerance within which a number is treated as 0 or -1.  The tolerance is the
single-precision epsilon, as in ROS."""
ERASED = -1.0
"""Value of a goal's tolerance that disables the tolerance of the controller."""


class Acceptance(NamedTuple):
    """The kinds of trajectories that a controller accepts."""

    joints: tuple[str, ...]
    allows_partial: bool = False
    """Whether goals may specify only some of the joints."""
    allows_moving_end: bool = False
    """Whether the last point may have nonzero velocities."""
    allows_integration: bool = False
    """Whether points may lack positions."""


def check_goal(goal: TrajectoryGoal, rules: Acceptance, now: float) -> tuple[str, ...]:
    """Return the joints to which the points' values apply, or reject the goal.

    ``now`` [s] is the time of the next update.
    """
    joints = rules.joints
    names = joints if goal.joint_names is None else tuple(goal.joint_names)
    if len(names) != len(joints) and not rules.allows_partial:
        missing = ", ".join(name for name in joints if name not in names)
        raise _invalid_joints(
            "Joints on incoming trajectory don't match the controller joints: it names "
            f"{len(names)} of {len(joints)}"
            + (f" and lacks {missing}" if missing else "")
            + "; allow_partial_joints_goal is false"
        )
    if not names:
        raise _invalid_joints("Empty joint names on incoming trajectory.")
    if not goal.points:
        raise GoalRejectedError("Empty trajectory received.")
    for name in names:
        if name not in joints:
            raise _invalid_joints(
                f"Incoming joint {name} doesn't match the controller's joints"
                + did_you_mean(name, joints)
            )
        if names.count(name) > 1:
            raise _invalid_joints(f"Incoming joint {name} is named twice")
    if not rules.allows_moving_end:
        _check_rest(goal.points[-1], names)
    _check_stamp(goal, now)
    _check_times(goal)
    for number in goal.suspects:
        _check_point(number, goal.points[number], names, rules)
    return names


def _check_rest(point: TrajectoryPoint, names: Sequence[str]) -> None:
    for name, velocity in zip(names, point.velocities or (), strict=False):
        if abs(velocity) > EPSILON:
            raise GoalRejectedError(
                f"Velocity of last trajectory point of joint {name} is not zero: "
                f"{velocity:.15f}; allow_nonzero_velocity_at_trajectory_end is false"
            )


def _check_stamp(goal: TrajectoryGoal, now: float) -> None:
    if goal.stamp is None or goal.stamp == 0.0:
        return
    if not math.isfinite(goal.stamp):
        raise GoalRejectedError(f"stamp {goal.stamp}; it must be a simulated time")
    end = goal.stamp + goal.times[-1]
    if end < now:
        raise GoalRejectedError(
            f"Received trajectory with non-zero start time ({goal.stamp:f}) that ends "
            f"in the past ({end:f}); it is {now:f}"
        )


def _check_times(goal: TrajectoryGoal) -> None:
    for number in goal.suspects:
        time = goal.times[number]
        if not math.isfinite(time):
            raise GoalRejectedError(f"point {number} has time_from_start {time}")
        if number and not time > goal.times[number - 1]:
            raise GoalRejectedError(
                f"Time between points {number - 1} and {number} is not strictly "
                f"increasing, it is {goal.times[number - 1]:f} and {time:f} "
                "respectively"
            )


def _check_point(
    number: int, point: TrajectoryPoint, names: Sequence[str], rules: Acceptance
) -> None:
    fields = {
        "positions": point.positions,
        "velocities": point.velocities or (),
        "accelerations": point.accelerations or (),
    }
    if rules.allows_integration and not any(fields.values()):
        raise GoalRejectedError(
            "The given trajectory has no position, velocity, or acceleration points."
            f" Point {number} has none."
        )
    for kind, values in fields.items():
        is_needed = kind == "positions" and not rules.allows_integration
        if len(values) != len(names) and (values or is_needed):
            raise GoalRejectedError(
                f"Mismatch between joint_names size ({len(names)}) and {kind} "
                f"({len(values)}) at point #{number}."
            )
        check_finite(number, kind, names, values)


def _invalid_joints(text: str) -> GoalRejectedError:
    return GoalRejectedError(text, GoalRejectedError.INVALID_JOINTS)


# ---- tolerances --------------------------------------------------------------------


def override_tolerances(
    goal: TrajectoryGoal, defaults: TrajectoryTolerances, controller: str
) -> TrajectoryTolerances:
    """Return a controller's tolerances, overridden by the tolerances of a goal.

    A positive tolerance in the goal replaces the default, -1 disables the tolerance,
    and 0 keeps the default.  If the goal contains any other value, an error is logged,
    and all defaults apply.
    """
    grace = _resolved(defaults.goal_time, goal.goal_time_tolerance or 0.0)
    if grace is None:
        logger.error(
            "%s: Specified illegal goal_time_tolerance: %f. Using default tolerances",
            controller,
            goal.goal_time_tolerance,
        )
        return defaults
    found = dict(defaults.joints)
    for kind, given in (("path", goal.path_tolerance), ("goal", goal.goal_tolerance)):
        for joint, override in given.items():
            default = found.get(joint)
            if default is None:
                logger.error(
                    "%s: joint '%s' specified in goal.%s_tolerance does not exist. "
                    "Using default tolerances.",
                    controller,
                    joint,
                    kind,
                )
                return defaults
            is_path = kind == "path"
            one = _override(default.path if is_path else default.goal, override)
            if one is None:
                logger.error(
                    "%s: joint '%s' specified in goal.%s_tolerance has an invalid "
                    "tolerance %s. Using default tolerances.",
                    controller,
                    joint,
                    kind,
                    override,
                )
                return defaults
            found[joint] = JointTolerances(
                path=one if is_path else default.path,
                goal=default.goal if is_path else one,
            )
    return TrajectoryTolerances(joints=found, goal_time=grace or math.inf)


def _override(default: Tolerance, override: ToleranceOverride) -> Tolerance | None:
    found = list(map(_resolved, default, as_tolerance(override)))
    values = [value for value in found if value is not None]
    return Tolerance(*values) if len(values) == len(found) else None


def _resolved(default: float, wanted: float) -> float | None:
    """Return the applicable tolerance, or None for an illegal value."""
    if wanted > 0.0:
        return wanted
    if abs(wanted - ERASED) < EPSILON:
        return 0.0
    return None if wanted < 0.0 else default


def active_tolerances(
    tolerances: TrajectoryTolerances, joints: Sequence[str], *, by_velocity: bool
) -> tuple[tuple[Tolerance, ...], tuple[Tolerance, ...]]:
    """Return the tolerances to check for each joint, on the path and at the goal.

    Velocities are checked only if ``by_velocity`` is set, which is the case for
    controllers that command velocities or efforts.
    """
    all_of = [tolerances.of(joint) for joint in joints]
    path, at_goal = [one.path for one in all_of], [one.goal for one in all_of]
    if not by_velocity:
        path = [Tolerance(one.position) for one in path]
        at_goal = [Tolerance(one.position) for one in at_goal]
    return tuple(path), tuple(at_goal)
