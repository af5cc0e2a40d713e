"""New trajectories out of the ones that are played and what is asked."""

from __future__ import annotations

from collections.abc import Sequence

from tool0.control import goal_check
from tool0.control.angles import wrap_offset
from tool0.control.goal import Goal
from tool0.control.joint_trajectory_spec import JointTrajectorySpec
from tool0.control.playback import hold_track, splice, splice_long, stop_track
from tool0.control.point_survey import MANY
from tool0.control.segment import MotionPlan
from tool0.control.track import Track, Way, motion_of, sample_track, with_goal
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.model import Joint, JointType


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
    survey = goal.survey
    goal_check.check_points(goal.points, names, survey)
    start = goal_check.start_time(goal, now)
    points = goal_check.points_ahead(goal.points, start, now)
    models = {joint.name: joint for joint in spec.joint_models}
    goal_check.check_limits(points, [models[name] for name in names], survey)
    played = dict(zip(models, old, strict=True))
    offsets = [
        _offset(models[name], played[name], max(now, start), position)
        for name, position in zip(names, points[0].positions, strict=True)
    ]
    schedule = None
    if survey is not None and len(points) >= MANY:
        shift = max(abs(offset or 0.0) for offset in offsets)
        schedule = survey.schedule(start, len(points), shift)
    tracks: list[Track] = []
    for name, was in played.items():
        if name not in names:
            tracks.append(with_goal(was, handle))
            continue
        column = names.index(name)
        offset = offsets[column]
        tolerances = spec.tolerances.of(
            name, goal.path_tolerance.get(name), goal.goal_tolerance.get(name)
        )
        if schedule is None:
            motions = [
                (start + point.time_from_start, motion_of(point, column, offset))
                for point in points
            ]
            track = splice(was, now, start, motions, goal=handle, tolerances=tolerances)
        else:
            times, suspects = schedule
            way = Way(times, points, column, offset)
            track = splice_long(
                was, now, start, way, suspects, goal=handle, tolerances=tolerances
            )
        tracks.append(track)
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


def _offset(joint: Joint, played: Track, time: float, first: float) -> float | None:
    """Return the whole turns that bring a first position nearest to what is played."""
    if joint.type is not JointType.CONTINUOUS:
        return None
    return wrap_offset(sample_track(played, time).position, first)
