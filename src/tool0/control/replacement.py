"""Trajectory replacement: new splines out of the running ones and a request."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from tool0.control import goal_check, spline
from tool0.control.goal import Goal
from tool0.control.segment import Motion, MotionPlan, wrap_offset
from tool0.control.spline import JointSpline, Knots
from tool0.control.tolerances import TrajectoryTolerances
from tool0.control.trajectory import MARGIN, TrajectoryGoal, TrajectoryPoint
from tool0.description.model import Joint, JointType

_COARSE = 1e-9
"""If times are rounded to more than this [s], every segment is examined."""


def follow_goal(
    running: Sequence[JointSpline],
    joints: Sequence[Joint],
    tolerances: TrajectoryTolerances,
    goal: TrajectoryGoal,
    names: tuple[str, ...],
    *,
    now: float,
    handle: Goal | None,
) -> list[JointSpline]:
    """Return a spline per joint of the controller, or reject the goal.

    Args:
        running: What is executed so far, one per joint.
        joints: Those of the controller.
        tolerances: Those of the controller.
        goal: What to do, with at least one point.
        names: The joints of the points' numbers.
        now: Simulated time of the coming update [s].
        handle: Whose tolerances hold; None for none.

    Joints that the goal does not name keep their splines, which count for it from now
    on, as in ROS.
    """
    goal_check.check_points(goal, names)
    start = goal_check.start_time(goal, now)
    first = goal_check.first_point_ahead(goal, start, now)
    models = {joint.name: joint for joint in joints}
    goal_check.check_limits(goal, [models[name] for name in names], first)
    old = dict(zip(models, running, strict=True))
    leave = max(now, start)
    offsets = [
        _offset(models[name], old[name], leave, position)
        for name, position in zip(names, goal.points[first].positions, strict=True)
    ]
    suspects = [number for number in goal.suspects if number > first]
    shift = max(abs(offset or 0.0) for offset in offsets)
    if shift > MARGIN or math.ulp(start + goal.times[-1]) > _COARSE:
        suspects = list(range(first + 1, len(goal.points)))
    splines: list[JointSpline] = []
    for name, before in old.items():
        if name not in names:
            splines.append(before.with_goal(handle))
            continue
        column = names.index(name)
        splines.append(
            before.spliced(
                now,
                start,
                Knots(goal.times, _motions(goal.points, column, offsets[column])),
                first=first,
                suspects=suspects,
                goal=handle,
                tolerances=tolerances.of(
                    name, goal.path_tolerance.get(name), goal.goal_tolerance.get(name)
                ),
            )
        )
    return splines


def follow_plan(
    running: Sequence[JointSpline],
    joints: Sequence[Joint],
    tolerances: TrajectoryTolerances,
    plan: MotionPlan,
    *,
    now: float,
    handle: Goal | None,
) -> list[JointSpline]:
    """Return a spline per joint along a plan that starts as the joints move ``now``."""
    return [
        before.spliced(
            now,
            now,
            Knots.of(path),
            suspects=range(1, len(path)),
            goal=handle,
            tolerances=tolerances.of(joint.name, None, None),
        )
        for joint, before, path in zip(joints, running, plan, strict=True)
    ]


def stop(
    running: Sequence[JointSpline],
    joints: Sequence[Joint],
    duration: float,
    measured: Sequence[float],
    *,
    now: float,
    handle: Goal | None,
) -> list[JointSpline]:
    """Return the splines to rest: at the measured positions, or by a ramp.

    Args:
        running: What is executed so far, one per joint.
        joints: Those of the controller.
        duration: Length of the ramp [s]; 0 for none.
        measured: Positions of the joints [rad | m].
        now: Simulated time of the coming update [s].
        handle: The goal that asks for it, if any.
    """
    if duration <= 0.0:
        return [spline.hold(now, position, handle) for position in measured]
    return [
        spline.stop(
            now,
            before.sample(now),
            duration,
            float if joint.type is JointType.CONTINUOUS else joint.limits.clamp,
            handle,
        )
        for joint, before in zip(joints, running, strict=True)
    ]


def _offset(
    joint: Joint, before: JointSpline, time: float, first: float
) -> float | None:
    """Return the whole turns that bring a first position nearest to the desired one."""
    if joint.type is not JointType.CONTINUOUS:
        return None
    return wrap_offset(before.sample(time).position, first)


def _motions(
    points: Sequence[TrajectoryPoint], column: int, offset: float | None
) -> Callable[[int], Motion]:
    """Return the function that tells what each point wants of one joint.

    Args:
        points: The points.
        column: Which of their numbers are the joint's.
        offset: What is added to the positions [rad], for a continuous joint.
    """

    def motion(number: int) -> Motion:
        point = points[number]
        position = point.positions[column]
        return Motion(
            position if offset is None else position + offset,
            point.velocities[column] if point.velocities else None,
            point.accelerations[column] if point.accelerations else None,
        )

    return motion
