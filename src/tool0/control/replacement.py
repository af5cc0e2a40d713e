"""Trajectory replacement: new splines out of the running ones and a request."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import final

from tool0.control import goal_check
from tool0.control.goal import Goal, TrajectoryTolerances
from tool0.control.segment import Motion, MotionPlan, wrap_offset
from tool0.control.spline import JointSpline, Knots, hold, stop
from tool0.control.trajectory import MARGIN, TrajectoryGoal, TrajectoryPoint
from tool0.description.model import Joint, JointType

_COARSE = 1e-9
"""If times are rounded to more than this [s], every segment is examined."""

Splines = Sequence[JointSpline]
"""One per joint of a controller."""


@final
class TrajectoryReplacement:
    """Makes the splines of one controller.

    In its methods ``running`` are the splines that are executed so far, ``now`` is the
    simulated time of the coming update [s], and ``handle`` is the goal whose tolerances
    hold from now on; None for none.
    """

    def __init__(
        self,
        joints: Sequence[Joint],
        tolerances: TrajectoryTolerances,
        stop_duration: float,
    ) -> None:
        """Take the controller's parameters.

        Args:
            joints: Those of the controller.
            tolerances: Those of the controller.
            stop_duration: Length of the ramp to rest [s]; 0 for none.
        """
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
        """Return the splines that follow a goal of at least one point, or reject it.

        ``names`` are the joints of the points' numbers.  Joints that are not among them
        keep their splines, which count for the goal from now on, as in ROS.
        """
        goal_check.check_points(goal, names)
        start = goal_check.start_time(goal, now)
        first = goal_check.first_point_ahead(goal, start, now)
        goal_check.check_limits(goal, [self._joints[name] for name in names], first)
        before = dict(zip(self._joints, running, strict=True))
        leave = max(now, start)
        offsets = [
            _offset(self._joints[name], before[name], leave, position)
            for name, position in zip(names, goal.points[first].positions, strict=True)
        ]
        suspects = [number for number in goal.suspects if number > first]
        shift = max(abs(offset or 0.0) for offset in offsets)
        if shift > MARGIN or math.ulp(start + goal.times[-1]) > _COARSE:
            suspects = list(range(first + 1, len(goal.points)))
        splines: list[JointSpline] = []
        for name, old in before.items():
            if name not in names:
                splines.append(old.with_goal(handle))
                continue
            column = names.index(name)
            motion = _motion_at(goal.points, column, offsets[column])
            tolerances = self._tolerances.of(
                name, goal.path_tolerance.get(name), goal.goal_tolerance.get(name)
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

    def by_plan(
        self, running: Splines, plan: MotionPlan, now: float, handle: Goal | None
    ) -> list[JointSpline]:
        """Return the splines along a plan that starts with the desired motion now."""
        return [
            old.spliced(
                now,
                now,
                Knots.of(path),
                suspects=range(1, len(path)),
                goal=handle,
                tolerances=self._tolerances.of(name, None, None),
            )
            for name, old, path in zip(self._joints, running, plan, strict=True)
        ]

    def by_stop(
        self,
        running: Splines,
        measured: Sequence[float],
        now: float,
        handle: Goal | None,
    ) -> list[JointSpline]:
        """Return the splines to rest: at the measured positions, or by a ramp."""
        duration = self._stop_duration
        if duration <= 0.0:
            return [hold(now, position, handle) for position in measured]
        return [
            stop(
                now,
                old.sample(now),
                duration,
                float if joint.type is JointType.CONTINUOUS else joint.limits.clamp,
                handle,
            )
            for joint, old in zip(self._joints.values(), running, strict=True)
        ]


def _offset(
    joint: Joint, before: JointSpline, time: float, first: float
) -> float | None:
    """Return the whole turns that bring a first position nearest to the desired one."""
    if joint.type is not JointType.CONTINUOUS:
        return None
    return wrap_offset(before.sample(time).position, first)


def _motion_at(
    points: Sequence[TrajectoryPoint], column: int, offset: float | None
) -> Callable[[int], Motion]:
    """Return the function that returns the motion of one joint at each point.

    Args:
        points: The points.
        column: Which of their numbers are the joint's.
        offset: What is added to the positions [rad], for a continuous joint.
    """

    def motion_at(number: int) -> Motion:
        point = points[number]
        position = point.positions[column]
        return Motion(
            position if offset is None else position + offset,
            point.velocities[column] if point.velocities else None,
            point.accelerations[column] if point.accelerations else None,
        )

    return motion_at
