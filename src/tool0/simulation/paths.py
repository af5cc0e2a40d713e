"""Conversions of a planned path to the inputs of a trajectory controller."""

from __future__ import annotations

from tool0.control.spline import Motion, MotionPlan
from tool0.motion.path import Path
from tool0.protocol.trajectories import TrajectoryPoint


def motion_plan(path: Path) -> MotionPlan:
    """Return a path as a plan that starts at a controller's setpoint."""
    times, columns = path.times[1:].tolist(), [path.positions, path.velocities]
    if path.accelerations is not None:
        columns.append(path.accelerations)
    return [
        list(zip(times, map(Motion, *motion), strict=True))
        for motion in zip(*(column[1:].T.tolist() for column in columns), strict=True)
    ]


def trajectory_points(path: Path) -> list[TrajectoryPoint]:
    """Return a path as the points of a goal that starts at the setpoint."""
    n_points, qdd = len(path.times) - 1, path.accelerations
    accelerations = [None] * n_points if qdd is None else qdd[1:].tolist()
    columns = (path.positions[1:], path.velocities[1:], path.times[1:])
    q, qd, times = (column.tolist() for column in columns)
    return list(map(TrajectoryPoint, q, qd, accelerations, times))
