"""Checks of a trajectory goal, and the splines that execute it.

If joint_trajectory_controller in ROS defines a message and a code for an error, the
checks use the same message and code.  Unlike ROS, the checks also reject numbers that
are not finite, duplicate joints, wrong numbers of positions, positions beyond a joint's
limits, and tolerances for joints that the controller does not have.  As in ROS, the
checks accept velocities and accelerations beyond a joint's limits: planners round these
values, and the tolerances detect whether the joint can follow.
"""

from __future__ import annotations

import logging
import math
from bisect import bisect_right
from collections.abc import Collection, Sequence
from typing import final

from tool0.control.goal_motion import (
    Splines,
    check_finite,
    check_limits,
    motion_at,
    start_time,
    suspects_after,
    whole_turns,
)
from tool0.control.spline import JointSpline, Knots, Sample, hold, stop
from tool0.control.tolerances import JointTolerances, TrajectoryTolerances, as_tolerance
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.model import Joint, JointType
from tool0.errors import GoalRejectedError, did_you_mean
from tool0.protocol.goals import Goal, Tolerance, ToleranceOverride
from tool0.protocol.trajectories import TrajectoryPoint

logger = logging.getLogger(__name__)

INSTANT = 1e-6
"""Remaining time to a point below which the point is considered reached [s].  The time
is shorter than any tick, but longer than the rounding errors of sums of times."""


def check_names(
    goal: TrajectoryGoal, joints: tuple[str, ...], *, allow_partial: bool
) -> tuple[str, ...]:
    """Return the joints to which the points' values apply, or reject the goal."""
    names = joints if goal.joint_names is None else tuple(goal.joint_names)
    for name in names:
        if name not in joints:
            raise _invalid_joints(f"unknown joint '{name}'", name, joints)
    for name in names:
        if names.count(name) > 1:
            raise _invalid_joints(f"joint '{name}' is named twice")
    if not names or (len(names) != len(joints) and not allow_partial):
        missing = ", ".join(name for name in joints if name not in names)
        raise _invalid_joints(
            f"the goal names {len(names)} of {len(joints)} joints and lacks {missing}"
            + ("" if allow_partial else "; allow_partial_joints_goal is false")
        )
    for tolerances in (goal.path_tolerance, goal.goal_tolerance):
        for name, override in tolerances.items():
            if name not in joints:
                raise _invalid_joints(
                    f"tolerance for unknown joint '{name}'", name, joints
                )
            if not all(map(math.isfinite, as_tolerance(override))):
                raise GoalRejectedError(f"tolerance {override} of '{name}'")
    if not math.isfinite(goal.goal_time_tolerance or 0.0):
        raise GoalRejectedError(f"goal_time_tolerance {goal.goal_time_tolerance}")
    return names


def check_points(goal: TrajectoryGoal, names: tuple[str, ...]) -> None:
    """Reject points with invalid times, counts or numbers."""
    for number in goal.suspects:
        time = goal.times[number]
        last = goal.times[number - 1] if number else -math.inf
        if not math.isfinite(time):
            raise GoalRejectedError(f"point {number} has time_from_start {time}")
        if not time > last:
            raise GoalRejectedError(
                "Trajectory message contains waypoints that are not strictly "
                f"increasing in time. Point {number} has time_from_start {time} s, "
                f"the one before it {last} s."
            )
    for number in goal.suspects:
        _check_counts(number, goal.points[number], names)


def _check_counts(number: int, point: TrajectoryPoint, names: tuple[str, ...]) -> None:
    if len(point.positions) != len(names):
        raise GoalRejectedError(
            "Size mismatch between trajectory point and vector specifying whether "
            f"joints wrap around. Point {number} has {len(point.positions)} positions "
            f"for {len(names)} joints."
        )
    for kind in ("positions", "velocities", "accelerations"):
        values = getattr(point, kind)
        if values and len(values) != len(names):
            raise GoalRejectedError(
                "Size mismatch in trajectory point position, velocity or acceleration "
                f"data. Point {number} has {len(values)} {kind} "
                f"for {len(names)} joints."
            )
        if values:
            check_finite(number, kind, names, values)


def first_point_ahead(goal: TrajectoryGoal, start: float, now: float) -> int:
    """Return the index of the first point that lies ahead, or reject the goal.

    Earlier points are dropped.  A point at the start, or up to ``INSTANT`` after the
    start, is also dropped: there is no time to move to the point, and ROS would command
    a jump.
    """
    earliest = max(start, now)
    n_points = len(goal.points)
    n_dropped = bisect_right(goal.times, earliest + INSTANT, key=start.__add__)
    if n_dropped == n_points:
        behind = earliest - (start + goal.times[-1])
        is_missing = goal.times[-1] == 0.0
        raise GoalRejectedError(
            f"Dropping all {n_dropped} trajectory point(s), as they occur before the "
            f"current time.\nLast point is {behind:.3f}s in the past."
            + ("  Its time_from_start is missing or 0." if is_missing else "")
        )
    if n_dropped > 1 or (n_dropped == 1 and start < now):
        logger.warning(
            "Dropping first %d trajectory point(s) out of %d, as they occur before "
            "the current time.\nFirst valid point will be reached in %.3fs.",
            n_dropped,
            n_points,
            start + goal.times[n_dropped] - now,
        )
    return n_dropped


def goal_time_with(default: float, override: float | None) -> float:
    """Return the time to arrive for a goal with a ``goal_time_tolerance`` [s].

    As for tolerances, a value > 0 replaces the default, and 0 keeps it.  A value < 0
    means no limit: the goal stays active until the joints arrive.  In ROS, a value < 0
    gives the joints no extra time.
    """
    if override is None or override == 0.0:
        return default
    return override if override > 0.0 else math.inf


def _override(default: Tolerance, override: ToleranceOverride | None) -> Tolerance:
    if override is None:
        return default
    pairs = zip(default, as_tolerance(override), strict=True)
    return Tolerance(*(max(new, 0.0) if new else old for old, new in pairs))


def _invalid_joints(
    text: str, name: str = "", valid: tuple[str, ...] = ()
) -> GoalRejectedError:
    hint = did_you_mean(name, valid) if valid else ""
    return GoalRejectedError(text + hint, GoalRejectedError.INVALID_JOINTS)


@final
class TrajectoryReplacement:
    """Creates the splines of one controller.

    In the methods, ``running`` contains the splines that are currently executed,
    ``now`` is the simulated time of the next update [s], and ``handle`` is the new
    goal, with the tolerances that apply, or None.
    """

    def __init__(
        self,
        joints: Sequence[Joint],
        tolerances: TrajectoryTolerances,
        stop_duration: float,
    ) -> None:
        """Store the controller's parameters; a stop takes ``stop_duration`` [s]."""
        self._joints = {joint.name: joint for joint in joints}
        self._tolerances = tolerances
        self._stop_duration = stop_duration

    def by_goal(
        self,
        running: Splines,
        goal: TrajectoryGoal,
        names: tuple[str, ...],
        now: float,
        handle: Goal | None,
    ) -> list[JointSpline]:
        """Return the splines for a goal with at least one point, or reject the goal.

        ``names`` lists the joints to which the points' values apply.  Other joints keep
        their splines, which become part of the goal, as they do in ROS.
        """
        check_points(goal, names)
        start = start_time(goal, now)
        first = first_point_ahead(goal, start, now)
        before = dict(zip(self._joints, running, strict=True))
        check_limits(
            goal,
            [self._joints[name] for name in names],
            first,
            lambda: [before[name].sample(now).position for name in names],
        )
        leave = max(now, start)
        offsets = [
            whole_turns(
                self._joints[name], before[name].sample(leave).position, position
            )
            for name, position in zip(names, goal.points[first].positions, strict=True)
        ]
        suspects = suspects_after(goal, first, start, offsets)
        splines: list[JointSpline] = []
        for name, old in before.items():
            if name not in names:
                splines.append(old.with_goal(handle))
                continue
            column = names.index(name)
            motion = motion_at(goal.points, column, offsets[column])
            default = self._tolerances.of(name)
            tolerances = JointTolerances(
                path=_override(default.path, goal.path_tolerance.get(name)),
                goal=_override(default.goal, goal.goal_tolerance.get(name)),
            )
            splines.append(
                old.spliced(
                    now,
                    start,
                    Knots(goal.times, motion),
                    first=first,
                    suspects=suspects,
                    goal=handle,
                    tolerances=tolerances,
                )
            )
        return splines

    def by_stop(
        self,
        running: Splines,
        positions: Sequence[float],
        velocities: Sequence[float],
        now: float,
        handle: Goal | None,
    ) -> list[JointSpline]:
        """Return splines that stop the joints, immediately or with a ramp.

        If the joints follow a trajectory, the ramp starts from the desired motion, as
        it does in ROS.  If the joints do not follow a trajectory, the ramp starts from
        the measured motion, within the joints' velocity limits.  The duration of a ramp
        from the measured motion is proportional to the speed, so that a sagging joint
        does not continue to move for the full duration.
        """
        whole = self._stop_duration
        joints = self._joints.values()
        desired = [old.sample(now) for old in running]
        follows = _are_followed(joints, desired, velocities)
        splines = []
        for joint, wanted, position, velocity in zip(
            joints, desired, positions, velocities, strict=True
        ):
            measured = Sample(position, joint.clamp_velocity(velocity), 0.0)
            start = wanted if follows else measured
            share = 1.0 if follows else abs(measured.velocity) / joint.max_velocity
            if not whole * share > 0.0:
                splines.append(hold(now, position, handle))
                continue
            clamp = float if joint.type is JointType.CONTINUOUS else joint.limits.clamp
            splines.append(stop(now, start, whole * share, clamp, handle))
        return splines


FOLLOWED = 0.1
"""Largest velocity error at which joints are considered to follow the trajectory, as a
fraction of the largest desired velocity."""


def _are_followed(
    joints: Collection[Joint], desired: Sequence[Sample], velocities: Sequence[float]
) -> bool:
    """Return whether the joints follow the desired motion.

    Joints that are blocked or overloaded do not follow the desired motion.
    """
    fastest = max(abs(wanted.velocity) for wanted in desired)
    return fastest > 0.0 and all(
        abs(wanted.velocity) <= joint.max_velocity
        and abs(wanted.velocity - velocity) <= FOLLOWED * fastest
        for joint, wanted, velocity in zip(joints, desired, velocities, strict=True)
    )
