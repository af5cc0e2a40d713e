"""New trajectories out of the ones that are played and what is asked."""

from __future__ import annotations

from collections.abc import Sequence

from tool0.control import goal_check
from tool0.control.angles import wrap_offset
from tool0.control.goal import Goal
from tool0.control.joint_trajectory_spec import JointTrajectorySpec
from tool0.control.playback import (
    Track,
    hold_track,
    sample_track,
    splice,
    stop_track,
)
from tool0.control.segment import Motion, MotionPlan
from tool0.control.trajectory import TrajectoryGoal, TrajectoryPoint
from tool0.description.model import JointType


def merged_tracks(
    spec: JointTrajectorySpec,
    old: Sequence[Track],
    goal: TrajectoryGoal,
    names: tuple[str, ...],
    *,
    now: float,
    handle: Goal | None,
) -> list[Track]:
    """Return a track per joint of the controller, or reject the goal.

    Args:
        spec: The controller's.
        old: What is played so far.
        goal: What to do, with at least one point.
        names: The joints of the points' numbers.
        now: Simulated time of the coming update [s].
        handle: Whose tolerances hold; None for none.

    Joints that the goal does not name keep their tracks, which count for it from now
    on, as in ROS.
    """
    goal_check.check_points(goal.points, names)
    start = goal_check.start_time(goal, now)
    points = goal_check.points_ahead(goal.points, start, now)
    models = {joint.name: joint for joint in spec.joint_models}
    goal_check.check_limits(points, [models[name] for name in names])
    tracks: list[Track] = []
    for joint, track in zip(spec.joint_models, old, strict=True):
        name = joint.name
        if name not in names:
            tracks.append(tuple(piece._replace(goal=handle) for piece in track))
            continue
        motions = _motions_of(points, names.index(name), start)
        if joint.type is JointType.CONTINUOUS:
            motions = _unwrap(motions, sample_track(track, max(now, start)).position)
        tolerances = spec.tolerances.of(
            name, goal.path_tolerance.get(name), goal.goal_tolerance.get(name)
        )
        tracks.append(
            splice(track, now, start, motions, goal=handle, tolerances=tolerances)
        )
    return tracks


def planned_tracks(
    spec: JointTrajectorySpec,
    old: Sequence[Track],
    plan: MotionPlan,
    *,
    now: float,
    handle: Goal | None,
) -> list[Track]:
    """Return a track per joint along a plan that starts as the joints move ``now``."""
    return [
        splice(
            track,
            now,
            now,
            [(now + after, motion) for after, motion in path],
            goal=handle,
            tolerances=spec.tolerances.of(name, None, None),
        )
        for name, track, path in zip(spec.joints, old, plan, strict=True)
    ]


def stopping_tracks(
    spec: JointTrajectorySpec,
    old: Sequence[Track],
    measured: Sequence[float],
    now: float,
    handle: Goal | None,
) -> list[Track]:
    """Return the way to rest: at the measured positions, or by a ramp."""
    duration = spec.stop_trajectory_duration
    if duration <= 0.0:
        return [hold_track(now, position, handle) for position in measured]
    return [
        stop_track(
            now,
            sample_track(track, now),
            duration,
            float if joint.type is JointType.CONTINUOUS else joint.limits.clamp,
            handle,
        )
        for joint, track in zip(spec.joint_models, old, strict=True)
    ]


def _motions_of(
    points: Sequence[TrajectoryPoint], column: int, start: float
) -> list[tuple[float, Motion]]:
    """Return absolute times and motions of one of the points' joints."""
    return [
        (
            start + point.time_from_start,
            Motion(
                point.positions[column],
                point.velocities[column] if point.velocities else None,
                point.accelerations[column] if point.accelerations else None,
            ),
        )
        for point in points
    ]


def _unwrap(
    motions: list[tuple[float, Motion]], previous: float
) -> list[tuple[float, Motion]]:
    """Turn all motions by the same whole turns, so that the first is the nearest."""
    offset = wrap_offset(previous, motions[0][1].position)
    return [
        (time, motion._replace(position=motion.position + offset))
        for time, motion in motions
    ]
