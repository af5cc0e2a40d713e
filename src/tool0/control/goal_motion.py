"""The motion of each joint through the points of a trajectory goal.

The module contains the code that ROS 1 and ROS 2 controllers share: checks of the
numbers, and splines along a plan.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from tool0.control.position_limits import check_position, position_range
from tool0.control.spline import (
    JointSpline,
    Knots,
    Motion,
    MotionPlan,
    wrap_offset,
)
from tool0.control.tolerances import TrajectoryTolerances
from tool0.control.trajectory import BLOCK, MARGIN, TrajectoryGoal
from tool0.description.model import Joint, JointType
from tool0.errors import GoalRejectedError
from tool0.protocol.goals import Goal
from tool0.protocol.trajectories import TrajectoryPoint

_COARSE = 1e-9
"""Rounding error of times [s] above which every segment is examined."""

Splines = Sequence[JointSpline]
"""One spline per joint of a controller."""


def start_time(goal: TrajectoryGoal, now: float) -> float:
    """Return the time at which the goal starts [s]."""
    if goal.stamp is None or goal.stamp == 0.0:
        return float(now)
    if not math.isfinite(goal.stamp):
        raise GoalRejectedError(f"stamp {goal.stamp}; it must be a simulated time")
    return float(goal.stamp)


def check_finite(
    number: int, kind: str, names: Sequence[str], values: Sequence[float]
) -> None:
    """Reject a point's values, one per name, if any value is not finite."""
    if all(map(math.isfinite, values)):
        return
    for name, value in zip(names, values, strict=True):
        if not math.isfinite(value):
            raise GoalRejectedError(
                f"point {number} has {kind} {value} for joint '{name}'; "
                "every number must be finite"
            )


def check_limits(
    goal: TrajectoryGoal,
    joints: Sequence[Joint],
    first: int,
    starts: Callable[[], Sequence[float]],
) -> None:
    """Reject positions, starting at point ``first``, that ``joints`` cannot reach.

    ``starts`` returns the joints' positions at the start [rad | m], since a goal may
    move back from a position beyond a limit.
    """
    limits = [position_range(joint) for joint in joints]
    blocks = [range(first, len(goal.points))]
    if goal.position_ranges is not None:
        blocks = [
            range(max(block * BLOCK, first), min((block + 1) * BLOCK, len(goal.points)))
            for block in goal.position_ranges.blocks_beyond(limits)
        ]
    for block in blocks:
        for number in block:
            positions = goal.points[number].positions
            for k, (lowest, highest) in enumerate(limits):
                if not lowest <= (position := positions[k]) <= highest:
                    start = starts()[k]
                    check_position(joints[k], position, f"point {number}", start)


def suspects_after(
    goal: TrajectoryGoal, first: int, start: float, turns: Sequence[float | None]
) -> Sequence[int]:
    """Return the points after ``first`` with possibly implausible segments.

    ``turns`` [rad] are added to the positions of continuous joints.
    """
    shift = max(abs(turn or 0.0) for turn in turns)
    if shift > MARGIN or math.ulp(start + goal.times[-1]) > _COARSE:
        return range(first + 1, len(goal.points))
    return [number for number in goal.suspects if number > first]


def whole_turns(joint: Joint, at: float, following: float) -> float | None:
    """Return the whole turns that move ``following`` closest to ``at`` [rad].

    The result is None if the joint is not continuous.
    """
    if joint.type is not JointType.CONTINUOUS:
        return None
    return wrap_offset(at, following)


def motion_at(
    points: Sequence[TrajectoryPoint], column: int, offset: float | None
) -> Callable[[int], Motion]:
    """Return a function that maps a point's index to the motion of joint ``column``.

    ``offset`` [rad] is added to the positions of a continuous joint.
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


def splines_by_plan(
    joints: Sequence[Joint],
    running: Splines,
    plan: MotionPlan,
    now: float,
    *,
    goal: Goal | None = None,
    tolerances: TrajectoryTolerances | None = None,
) -> list[JointSpline]:
    """Return splines along a plan that starts with the desired motion at ``now``."""
    found = tolerances or TrajectoryTolerances()
    return [
        old.spliced(
            now,
            now,
            Knots.of(path),
            suspects=(),
            goal=goal,
            tolerances=found.of(joint.name),
        )
        for joint, old, path in zip(joints, running, plan, strict=True)
    ]
