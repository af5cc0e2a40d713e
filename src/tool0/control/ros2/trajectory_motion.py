"""Motion of joints along a ROS 2 trajectory, and motion to rest.

Times are trajectory times, which lag behind simulated time if the speed was reduced.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from operator import attrgetter
from typing import NamedTuple

from tool0.control.goal_motion import (
    Splines,
    motion_at,
    suspects_after,
    whole_turns,
)
from tool0.control.spline import (
    JointSpline,
    Knots,
    Motion,
    Segment,
    SplineSection,
    along,
    hold,
    section_through,
)
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.model import Joint


class Course(NamedTuple):
    """A trajectory and its start time."""

    goal: TrajectoryGoal
    names: tuple[str, ...]
    """The joints to which the points' values apply."""
    start: float
    """Start time [s]."""
    is_stepped: bool
    """Whether points are commanded without interpolation."""

    def integrated(self, origins: Mapping[str, Motion]) -> Course:
        """Return the course, with integrated positions for points without positions."""
        return self._replace(goal=_integrated(self.goal, self.names, origins))

    def first_ahead(self, leave: float) -> int:
        """Return the index of the first point that is later than ``leave`` [s]."""
        return bisect_right(self.goal.times, leave, key=self.start.__add__)

    def section(self, joint: Joint, leave: float, origin: Motion) -> SplineSection:
        """Return a joint's motion from its ``origin`` at ``leave`` [s] to the end.

        If the next point is the first point of the trajectory, the joint moves there
        from its ``origin``.  If the next point is a later point, the joint is already
        moving between two points.

        Raises:
            GoalRejectedError: If a segment is implausible.
        """
        points, column = self.goal.points, self.names.index(joint.name)
        ahead = min(self.first_ahead(leave), len(points) - 1)
        turn = whole_turns(joint, origin.position, points[ahead].positions[column])
        return self._through(motion_at(points, column, turn), leave, origin, turn)

    def rest(self, position: float, leave: float, origin: Motion) -> SplineSection:
        """Return a motion that brings a joint that is not in the trajectory to rest."""

        def held(number: int) -> Motion:
            point = self.goal.points[number]
            return Motion(
                position,
                0.0 if point.velocities else None,
                0.0 if point.accelerations else None,
            )

        return self._through(held, leave, origin, None)

    def _through(
        self,
        motion: Callable[[int], Motion],
        leave: float,
        origin: Motion,
        turn: float | None,
    ) -> SplineSection:
        knots, start = Knots(self.goal.times, motion, self.is_stepped), self.start
        first = self.first_ahead(leave)
        if first == len(knots.times):
            return hold(leave, motion(first - 1).position).sections[0]
        from_here = leave, origin
        if first > 0:
            from_here = start + knots.times[first - 1], motion(first - 1)
        suspects = suspects_after(self.goal, first, start, (turn,))
        return section_through(start, knots, from_here, first=first, suspects=suspects)


def splines_at_once(
    joints: Sequence[Joint],
    course: Course,
    time: float,
    origins: Mapping[str, Motion],
    held: Mapping[str, float],
) -> list[JointSpline]:
    """Return the splines of a trajectory that replaces all previous motion.

    Args:
        joints: Joints of the controller.
        course: The trajectory.
        time: Time at which the execution of the trajectory starts [s].
        origins: Motion of each joint at ``time``.
        held: Positions of the joints that the trajectory does not contain; these joints
            stay at their positions [rad | m].

    Raises:
        GoalRejectedError: If a segment is implausible.
    """
    whole = course.integrated(origins)
    return [
        JointSpline(
            (
                whole.section(joint, time, origins[joint.name])
                if joint.name in course.names
                else whole.rest(held[joint.name], time, origins[joint.name]),
            )
        )
        for joint in joints
    ]


def splines_spliced(
    joints: Sequence[Joint], running: Splines, course: Course, now: float
) -> list[JointSpline]:
    """Return the splines of a trajectory that continues the ``running`` splines.

    The running splines are executed from ``now`` [s] until the trajectory starts.
    Joints that the trajectory does not contain continue to follow the running splines.

    Raises:
        GoalRejectedError: If a segment is implausible.
    """
    found, start = [], course.start
    for joint, old in zip(joints, running, strict=True):
        if joint.name in course.names:
            section = course.section(joint, start, Motion(*old.sample(start)))
            found.append(old.followed_by(section, now, start))
        else:
            found.append(old)
    return found


# ---- motion to rest ----------------------------------------------------------------


def decelerated(
    time: float, position: float, velocity: float, deceleration: float
) -> JointSpline:
    """Return the spline of a joint that decelerates at a constant rate [rad/s²].

    ``position`` and ``velocity`` are the motion at ``time`` [s].
    """
    if velocity == 0.0:
        return hold(time, position)
    rate = math.copysign(deceleration, velocity)
    terms = (position, velocity, -0.5 * rate, 0.0, 0.0, 0.0)
    return along(Segment.of(time, time + velocity / rate, terms))


# ---- points without positions or velocities ------------------------------------------


def _integrated(
    goal: TrajectoryGoal, names: Sequence[str], origins: Mapping[str, Motion]
) -> TrajectoryGoal:
    """Return the goal, with integrated positions for points without positions.

    The positions are computed from the velocities or accelerations.  As in ROS, the
    mean of the values at two points is used between them.
    """
    if all(point.positions for point in goal.points):
        return goal
    n = len(names)
    q = [origins[name].position for name in names]
    qd = [origins[name].velocity or 0.0 for name in names]
    qdd, time = [0.0] * n, 0.0
    points = []
    for point in goal.points:
        dt, time = point.time_from_start - time, point.time_from_start
        accelerations = point.accelerations or [0.0] * n
        velocities = point.velocities
        if not point.positions:
            if velocities is None:
                velocities = [
                    v + (a + b) * 0.5 * dt
                    for v, a, b in zip(qd, qdd, accelerations, strict=True)
                ]
            q = [
                p + (v + w) * 0.5 * dt
                for p, v, w in zip(q, qd, velocities, strict=True)
            ]
            point = replace(point, positions=q, velocities=velocities)  # noqa: PLW2901
        q, qd = list(point.positions), list(velocities or [0.0] * n)
        qdd = list(accelerations)
        points.append(point)
    return replace(goal, points=points)


def upsampled(goal: TrajectoryGoal, frequency: float) -> TrajectoryGoal:
    """Return a goal with positions, and with velocities from a smooth cubic spline.

    The spline starts and ends at rest, and its accelerations are continuous.  If the
    points have no times, and ``frequency`` [Hz] is not 0, it determines their times.
    """
    points = list(goal.points)
    is_plain = map(attrgetter("velocities", "accelerations"), points)
    if not all(point.positions for point in points) or any(v or a for v, a in is_plain):
        return goal
    if frequency > 0.0 and not any(goal.times):
        points = [
            replace(point, time_from_start=(k + 1) / frequency)
            for k, point in enumerate(points)
        ]
    times = [point.time_from_start for point in points]
    steps = [b - a for a, b in pairwise(times)]
    sizes = {len(point.positions) for point in points}
    if len(points) > 1 and len(sizes) == 1 and all(step > 0.0 for step in steps):
        columns = zip(*(point.positions for point in points), strict=True)
        velocities = zip(
            *(_smooth_velocities(column, steps) for column in columns), strict=True
        )
        points = [
            replace(point, velocities=row)
            for point, row in zip(points, velocities, strict=True)
        ]
    return replace(goal, points=points)


def _smooth_velocities(q: Sequence[float], steps: Sequence[float]) -> list[float]:
    """Return the velocities of a cubic spline through ``q`` with rest at both ends.

    Each inner knot yields one equation: the accelerations on both sides are equal.  The
    system of equations is solved by forward elimination and back substitution.
    """
    upper, right = [0.0], [0.0]
    for k in range(1, len(q) - 1):
        before, after = steps[k - 1], steps[k]
        rise = (q[k + 1] - q[k]) / after**2 + (q[k] - q[k - 1]) / before**2
        pivot = 2.0 * (1.0 / before + 1.0 / after) - upper[-1] / before
        right.append((3.0 * rise - right[-1] / before) / pivot)
        upper.append(1.0 / after / pivot)
    found = [0.0]
    for a, b in zip(reversed(upper[1:]), reversed(right[1:]), strict=True):
        found.append(b - a * found[-1])
    return [0.0, *reversed(found)]
