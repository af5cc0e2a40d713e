"""Smooth motions of several joints within their limits, from any motion to rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate
from typing import TYPE_CHECKING, Protocol

import numpy as np

from tool0.description.model import Joint, JointType, shortest_turn
from tool0.errors import ControlError
from tool0.motion.path import Path
from tool0.motion.rules import TIME_TO_FULL_ACCELERATION

if TYPE_CHECKING:
    import ruckig

SLOWEST = 0.01
"""Minimum fraction of the joints' maximum velocities that can be requested."""
SPACING = 1e-4
"""Minimum time between two changes of jerk [s]. Changes that are closer together are
merged, which has no visible effect."""
_DOUBLINGS = 10
_ROUNDING = 1e-6
"""Tolerance for a joint beyond a position limit [rad | m], and relative tolerance for a
velocity limit."""
_LEAST_ROOM = 0.01
"""Fraction by which a joint may exceed its velocity limit while its acceleration
decreases. Without a positive fraction, the jerk would be infinite."""
_MARGIN = 1.01
"""Factor that prevents planned motions from exactly reaching a limit, where the
planner's equations have no numerical solution."""


class MovingJoints(Protocol):
    """Motions of joints; each sequence has shape (n_joints,)."""

    @property
    def positions(self) -> Sequence[float]:
        """Positions [rad | m]."""

    @property
    def velocities(self) -> Sequence[float]:
        """Velocities [rad/s | m/s]."""

    @property
    def accelerations(self) -> Sequence[float]:
        """Accelerations [rad/s² | m/s²]."""


def plan_joints(
    joints: Sequence[Joint],
    start: MovingJoints,
    targets: Sequence[float],
    *,
    speed: float,
) -> Path:
    """Return the fastest motion within the limits that comes to rest at ``targets``.

    All joints reach their targets at the same time. There is a knot at each change of a
    joint's jerk, so the quintics between the knots are exactly the planned motion. A
    joint that moves too fast to stop before its limit brakes harder than the other
    joints.

    Args:
        joints: The joints to move, with their limits.
        start: Motion of the joints at time 0, such as the desired state of a trajectory
            controller.
        targets: Target positions [rad | m] within the limits. A continuous joint turns
            in the shorter direction.
        speed: Fraction of each joint's maximum velocity, SLOWEST … 1. The limits of
            acceleration and jerk do not change, so motions at different speeds can
            follow each other.

    Raises:
        ControlError: If ``speed`` is out of range.
    """
    require_speed(speed)
    ends = [
        q + shortest_turn(q, end) if joint.type is JointType.CONTINUOUS else end
        for joint, q, end in zip(joints, start.positions, targets, strict=True)
    ]
    return _path(joints, start, ends, _within_limits(joints, start, ends, speed))


def plan_cubic(
    joints: Sequence[Joint],
    start: MovingJoints,
    targets: Sequence[float],
    duration: float,
) -> Path:
    """Return the cubic that comes to rest at ``targets`` [rad | m] in ``duration`` [s].

    Raises:
        ControlError: If a joint would exceed its velocity limit.
    """
    for joint, q, qd, end in zip(
        joints, start.positions, start.velocities, targets, strict=True
    ):
        _check_peak(joint, end - q, qd, duration)
    ends = np.array([start.positions, targets], dtype=np.float64)
    speeds = np.array([start.velocities, [0.0] * len(joints)], dtype=np.float64)
    return Path(
        joint_names=tuple(joint.name for joint in joints),
        times=np.array([0.0, duration]),
        positions=ends,
        velocities=speeds,
    )


def require_speed(speed: float) -> None:
    """Raise ControlError if ``speed`` is not within SLOWEST … 1."""
    if not SLOWEST <= speed <= 1.0:
        raise ControlError(
            f"speed must be in [{SLOWEST}, 1], got {speed}: it is a fraction of the "
            "joints' largest velocities"
        )


def import_planner() -> None:
    """Import the planner in advance, because the import takes a few milliseconds."""
    import ruckig  # noqa: F401


def _within_limits(
    joints: Sequence[Joint], start: MovingJoints, ends: Sequence[float], speed: float
) -> ruckig.Trajectory:
    """Plan with increasing deceleration until no joint exceeds its limits."""
    hardness = [1.0] * len(joints)
    motion = None
    for _ in range(1 + _DOUBLINGS):
        found = _solve(joints, start, ends, speed, hardness)
        if found is None:  # by chance, or because the start is far too fast
            harder = _MARGIN if hardness == [1.0] * len(joints) else 2.0
            hardness = [harder * factor for factor in hardness]
            continue
        motion = found
        outside = _joints_outside(joints, start, motion)
        if not outside:
            break
        for k in outside:
            hardness[k] *= 2.0
    if motion is not None:
        return motion
    ways = zip(joints, start.positions, ends, strict=True)
    moved = ", ".join(f"'{joint.name}' from {q:g} to {end:g}" for joint, q, end in ways)
    raise ControlError(
        f"found no motion of {moved} at speed {speed:g}; check the velocity limits"
    )


def _joints_outside(
    joints: Sequence[Joint], start: MovingJoints, motion: ruckig.Trajectory
) -> list[int]:
    """Return the joints that would exceed their limits, or exceed them by even more."""
    return [
        k
        for k, (joint, extremes) in enumerate(
            zip(joints, motion.position_extrema, strict=True)
        )
        if joint.type is not JointType.CONTINUOUS
        and not (
            min(joint.limits.lower, start.positions[k]) - _ROUNDING <= extremes.min
            and extremes.max <= max(joint.limits.upper, start.positions[k]) + _ROUNDING
        )
    ]


def _solve(
    joints: Sequence[Joint],
    start: MovingJoints,
    ends: Sequence[float],
    speed: float,
    hardness: Sequence[float],
) -> ruckig.Trajectory | None:
    """Return the motion; None if the planner's equations fail."""
    import ruckig  # not annotated, so its values are Any

    velocities = [joint.max_velocity for joint in joints]
    wanted = ruckig.InputParameter(len(joints))
    wanted.current_position = list(start.positions)
    wanted.current_velocity = list(start.velocities)
    wanted.current_acceleration = list(start.accelerations)
    wanted.target_position = list(ends)
    wanted.max_velocity = [speed * velocity for velocity in velocities]
    wanted.max_acceleration = [
        factor * joint.max_acceleration
        for factor, joint in zip(hardness, joints, strict=True)
    ]
    wanted.max_jerk = [
        max(
            min(
                factor * acceleration / TIME_TO_FULL_ACCELERATION,
                factor * joint.limits.jerk,
            ),
            _jerk_to_stay_below(joint.max_velocity, qd, qdd),
        )
        for factor, acceleration, joint, qd, qdd in zip(
            hardness,
            wanted.max_acceleration,
            joints,
            start.velocities,
            start.accelerations,
            strict=True,
        )
    ]
    motion = ruckig.Trajectory(len(joints))
    # The path is a straight line in joint space if this is possible. Synchronizing the
    # joints fails numerically about once in 20000 motions; separate planning fails less
    # often.
    for together in (ruckig.Synchronization.Phase, ruckig.Synchronization.No):
        wanted.synchronization = together
        try:
            ruckig.Ruckig(len(joints)).calculate(wanted, motion)
        except (ruckig.RuckigError, ValueError):  # ValueError: a code without a name
            continue
        return motion
    return None


def _jerk_to_stay_below(limit: float, qd: float, qdd: float) -> float:
    """Return the jerk that ends an acceleration before the velocity becomes too high.

    The acceleration of a user's goal may be much higher than that of a planned motion.
    If a very high acceleration ended with the usual jerk, the speed of the joint would
    increase by qdd² / (2 jerk) before the acceleration reached 0.
    """
    most = max(limit, abs(qd))
    room = max(most - math.copysign(qd, qd * qdd), _LEAST_ROOM * most)
    return _MARGIN * qdd * qdd / (2.0 * room)


def _path(
    joints: Sequence[Joint],
    start: MovingJoints,
    ends: Sequence[float],
    motion: ruckig.Trajectory,
) -> Path:
    """Return a motion with knots at changes of jerk that are SPACING or more apart."""
    changes = {
        time
        for profile in motion.profiles[0]
        for time in accumulate([*profile.brake.t, *profile.t])
    }
    last = max(*changes, SPACING)
    times, knots = [0.0], [(start.positions, start.velocities, start.accelerations)]
    for time in sorted(changes):
        if time - times[-1] >= SPACING and last - time >= SPACING:
            times.append(time)
            knots.append(motion.at_time(time))
    rest = [0.0] * len(joints)
    times.append(last)
    knots.append((ends, rest, rest))
    q, qd, qdd = np.array(knots, dtype=np.float64).swapaxes(0, 1)
    endless = [joint.type is JointType.CONTINUOUS for joint in joints]
    lower = np.where(endless, -np.inf, [joint.limits.lower for joint in joints])
    upper = np.where(endless, np.inf, [joint.limits.upper for joint in joints])
    np.clip(q, np.minimum(q[0], lower), np.maximum(q[0], upper), out=q)
    q[-1] = ends
    return Path(
        joint_names=tuple(joint.name for joint in joints),
        times=np.array(times),
        positions=q,
        velocities=qd,
        accelerations=qdd,
    )


def _check_peak(joint: Joint, way: float, qd: float, duration: float) -> None:
    """Raise ControlError if a joint is too fast on a cubic from ``qd`` to rest."""
    limit = max(joint.max_velocity, abs(qd)) * (1.0 + _ROUNDING)
    peak = _peak_speed(way, qd, duration)
    if not peak > limit:
        return
    enough = max(duration, abs(way) / limit)
    while _peak_speed(way, qd, enough) > limit:
        enough *= 1.01
    digit = 10.0 ** (math.floor(math.log10(enough)) - 1)
    unit = "m/s" if joint.type is JointType.PRISMATIC else "rad/s"
    raise ControlError(
        f"joint '{joint.name}' needs {peak:.3g} {unit}, limit "
        f"{joint.max_velocity:.3g} {unit}; use a duration of at least "
        f"{math.ceil(enough / digit) * digit:g} s"
    )


def _peak_speed(way: float, qd: float, duration: float) -> float:
    """Return the maximum speed of a cubic from a velocity to rest [rad/s | m/s].

    The speed is highest at the start or where the acceleration is 0.
    """
    slope = 6.0 * way / duration - 4.0 * qd
    bend = 3.0 * qd - 6.0 * way / duration
    if not bend:
        return abs(qd)
    u = min(max(-slope / (2.0 * bend), 0.0), 1.0)
    return max(abs(qd), abs(qd + u * (slope + u * bend)))
