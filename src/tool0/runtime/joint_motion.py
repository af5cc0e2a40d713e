"""Smooth motions of several joints: within their limits, from any motion to rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate
from typing import TYPE_CHECKING

from tool0.control.angles import shortest_turn
from tool0.control.goal_check import ROUNDING
from tool0.control.trajectory import JointsMotion, TrajectoryPoint
from tool0.description.model import Joint, JointType
from tool0.errors import ControlError

if TYPE_CHECKING:
    import ruckig

SLOWEST = 0.01
"""Smallest part of the joints' largest velocities that may be asked for."""
TIME_TO_FULL_SPEED = 0.4
"""[s], at the largest acceleration.  A guess, as no datasheet of the UR tells one: the
shoulder of a UR5 gets 7.9 rad/s², which its drive can give to the outstretched arm."""
TIME_TO_FULL_ACCELERATION = 0.1
"""[s], at the largest jerk; a guess: shorter makes the arm ring, longer feels slow."""
UNLIMITED = {JointType.PRISMATIC: 0.25}
"""Velocity of joints whose model gives none [m/s]."""
UNLIMITED_TURN = 1.0
"""The same of joints that turn [rad/s]."""
SPACING = 1e-4
"""Points nearer to each other than this are one [s]: too short for jerk to show."""
_DOUBLINGS = 10


def plan_motion(
    joints: Sequence[Joint],
    start: JointsMotion,
    targets: Sequence[float],
    *,
    speed: float,
) -> list[TrajectoryPoint]:
    """Return the points of a motion to rest at ``targets``, all joints at once.

    Between two points every joint has one jerk, so that the quintics which a
    trajectory controller lays through them are the planned motion itself.  A joint
    that moves too fast to stop before its limit brakes harder than the others.

    Args:
        joints: The joints of the numbers, with their limits.
        start: How they move at time 0, as a trajectory controller wants it.
        targets: Where to [rad | m], within the limits; a continuous joint goes the
            shortest way round.
        speed: Part of each joint's largest velocity, SLOWEST … 1.  Acceleration and
            jerk stay, so that motions at any speed can follow each other.

    Raises:
        ControlError: If ``speed`` is out of range.
    """
    if not SLOWEST <= speed <= 1.0:
        raise ControlError(f"speed must be in [{SLOWEST}, 1], got {speed}")
    ends = [
        q + shortest_turn(q, end) if joint.type is JointType.CONTINUOUS else end
        for joint, q, end in zip(joints, start.positions, targets, strict=True)
    ]
    motion = _within_limits(joints, start, ends, speed)
    times = _times(motion)
    points = [_point(joints, motion.at_time(time), time) for time in times[:-1]]
    rest = (0.0,) * len(ends)
    return [*points, TrajectoryPoint(ends, rest, rest, time_from_start=times[-1])]


def largest_velocity(joint: Joint) -> float:
    """Return how fast a joint may move [rad/s | m/s], by its model or by a guess."""
    if math.isfinite(joint.limits.velocity):
        return joint.limits.velocity
    return UNLIMITED.get(joint.type, UNLIMITED_TURN)


def _within_limits(
    joints: Sequence[Joint], start: JointsMotion, ends: Sequence[float], speed: float
) -> ruckig.Trajectory:
    """Plan with ever harder braking until no joint passes its limits."""
    hardness = [1.0] * len(joints)
    motion = _solve(joints, start, ends, speed, hardness)
    for _ in range(_DOUBLINGS):
        outside = [
            k
            for k, (joint, extremes) in enumerate(
                zip(joints, motion.position_extrema, strict=True)
            )
            if joint.type is not JointType.CONTINUOUS
            and not (
                min(joint.limits.lower, start.positions[k]) - ROUNDING <= extremes.min
                and extremes.max
                <= max(joint.limits.upper, start.positions[k]) + ROUNDING
            )
        ]
        if not outside:
            break
        for k in outside:
            hardness[k] *= 2.0
        motion = _solve(joints, start, ends, speed, hardness)
    return motion


def _solve(
    joints: Sequence[Joint],
    start: JointsMotion,
    ends: Sequence[float],
    speed: float,
    hardness: Sequence[float],
) -> ruckig.Trajectory:
    import ruckig  # without annotations: its values are Any

    velocities = [largest_velocity(joint) for joint in joints]
    wanted = ruckig.InputParameter(len(joints))
    wanted.current_position = list(start.positions)
    wanted.current_velocity = list(start.velocities)
    wanted.current_acceleration = list(start.accelerations)
    wanted.target_position = list(ends)
    wanted.max_velocity = [speed * velocity for velocity in velocities]
    wanted.max_acceleration = [
        factor * velocity / TIME_TO_FULL_SPEED
        for factor, velocity in zip(hardness, velocities, strict=True)
    ]
    wanted.max_jerk = [
        factor * acceleration / TIME_TO_FULL_ACCELERATION
        for factor, acceleration in zip(hardness, wanted.max_acceleration, strict=True)
    ]
    motion = ruckig.Trajectory(len(joints))
    # A straight line in joint space where that is possible.  Making joints arrive
    # together fails numerically about once in 20000; each for itself always works.
    for together in (ruckig.Synchronization.Phase, ruckig.Synchronization.No):
        wanted.synchronization = together
        try:
            ruckig.Ruckig(len(joints)).calculate(wanted, motion)
        except ruckig.RuckigError:
            continue
        return motion
    raise ControlError(f"found no motion from {start} to {ends}")


def _times(motion: ruckig.Trajectory) -> list[float]:
    """Return when any joint's jerk changes, SPACING apart, and the end [s]."""
    end = max(motion.duration, SPACING)
    changes = {
        time
        for profile in motion.profiles[0]
        for time in accumulate([*profile.brake.t, *profile.t])
    }
    times = [0.0]
    for time in sorted(changes):
        if time - times[-1] >= SPACING and end - time >= SPACING:
            times.append(time)
    return [*times[1:], end]


def _point(
    joints: Sequence[Joint],
    motion: tuple[Sequence[float], Sequence[float], Sequence[float]],
    time: float,
) -> TrajectoryPoint:
    positions, velocities, accelerations = motion
    return TrajectoryPoint(
        [
            q if joint.type is JointType.CONTINUOUS else joint.limits.clamp(q)
            for joint, q in zip(joints, positions, strict=True)
        ],
        velocities,
        accelerations,
        time_from_start=time,
    )
