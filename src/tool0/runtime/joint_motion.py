"""Smooth motions of several joints: within their limits, from any motion to rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING

from tool0.control.controller import TrajectoryFollower
from tool0.control.manager import ControllerManager
from tool0.control.position_limits import ROUNDING, check_position
from tool0.control.spline import Motion, MotionPlan, Segment, shortest_turn
from tool0.description.model import Joint, JointType
from tool0.errors import ControlError, GoalRejectedError, did_you_mean
from tool0.protocol.controllers import Role, why_not_driven
from tool0.protocol.trajectories import JointsMotion

if TYPE_CHECKING:
    import ruckig

SLOWEST = 0.01
"""Smallest fraction of the joints' largest velocities that can be requested."""
TIME_TO_FULL_ACCELERATION = 0.1
"""[s], at the largest jerk; a guess: shorter makes the arm ring, longer feels slow."""
SPACING = 1e-4
"""Changes nearer to each other than this are one [s]: too short for jerk to show."""
_DOUBLINGS = 10
_LEAST_ROOM = 0.01
"""Part of a velocity limit by which a joint may exceed it while it stops speeding up:
less would take an infinite jerk."""
_MARGIN = 1.01
"""By which planned motions differ from those for which the planner's equations have no
solution in numbers: those that just reach a limit."""


def plan_motion(
    joints: Sequence[Joint],
    start: JointsMotion,
    targets: Sequence[float],
    *,
    speed: float,
) -> MotionPlan:
    """Return a motion to rest at ``targets`` that is the shortest within the limits.

    The joints arrive together.  Each joint has points where its jerk changes, so
    that the quintics of a trajectory controller between them are the planned motion.
    One that moves too fast to stop before its limit brakes harder than the others.

    Args:
        joints: The joints of the numbers, with their limits.
        start: Their motion at time 0, as desired by a trajectory controller.
        targets: Targets [rad | m], within the limits; a continuous joint goes the
            shortest way round.
        speed: Fraction of each joint's largest velocity, SLOWEST … 1.  Acceleration and
            jerk stay, so that motions at any speed can follow each other.

    Raises:
        ControlError: If ``speed`` is out of range.
    """
    require_speed(speed)
    ends = [
        q + shortest_turn(q, end) if joint.type is JointType.CONTINUOUS else end
        for joint, q, end in zip(joints, start.positions, targets, strict=True)
    ]
    motion = _within_limits(joints, start, ends, speed)
    return [
        _path(joint, k, motion, start.positions[k], end)
        for k, (joint, end) in enumerate(zip(joints, ends, strict=True))
    ]


def joints_by_controller(
    manager: ControllerManager, positions: Mapping[str, float]
) -> Mapping[str, Mapping[str, float]]:
    """Return the positions of each running trajectory controller's joints.

    Raises:
        ControlError: If no such controller drives a joint.
    """
    owners = {
        joint: status.name
        for status in manager.list()
        if status.is_running and status.role is Role.TRAJECTORY
        for joint in status.joints
    }
    found: dict[str, dict[str, float]] = {}
    for joint, position in positions.items():
        if joint not in owners:
            raise ControlError(why_not_driven(manager.list(), [joint]))
        found.setdefault(owners[joint], {})[joint] = position
    return found


def planned_motion(
    controller: TrajectoryFollower,
    positions: Mapping[str, float],
    *,
    speed: float,
    now: float,
) -> MotionPlan:
    """Return a smooth motion from the controller's present setpoint to ``positions``.

    Its other joints continue their motion, or stay.

    Args:
        controller: Whose joints; it does not change.
        positions: Joint → target [rad | m].
        speed: Fraction of each joint's largest velocity.
        now: Simulated time of the coming update [s].

    Raises:
        GoalRejectedError: If a joint is not the controller's, or a position is out of
            its limits.
        ControlError: If ``speed`` is out of range.
    """
    spec = controller.spec
    for name, position in positions.items():
        if name not in spec.joints:
            raise GoalRejectedError(
                f"joint '{name}' is not one of '{spec.name}'"
                + did_you_mean(name, spec.joints),
                GoalRejectedError.INVALID_JOINTS,
            )
        if not math.isfinite(position):
            raise GoalRejectedError(
                f"position {position} for joint '{name}'; it must be finite"
            )
    targets = []
    for joint, end in zip(
        spec.joint_models, controller.setpoint().target(), strict=True
    ):
        if joint.name in positions:
            check_position(joint, positions[joint.name], f"a motion of '{spec.name}'")
        # The present end of a joint that is left out may be beyond its limits.
        targets.append(positions.get(joint.name, joint.limits.clamp(end)))
    start = controller.query_state(now)
    return plan_motion(spec.joint_models, start, targets, speed=speed)


def require_velocities(
    joints: Sequence[Joint],
    start: JointsMotion,
    positions: Mapping[str, float],
    duration: float,
) -> None:
    """Raise ControlError if a cubic to rest exceeds a joint's velocity limit.

    Args:
        joints: The joints of ``start``, with their limits.
        start: Their motion at the beginning.
        positions: Joint → target [rad | m].
        duration: Duration of the motion [s].
    """
    for joint, q, qd in zip(joints, start.positions, start.velocities, strict=True):
        if not math.isfinite(positions.get(joint.name, math.nan)):
            continue  # not moved, or rejected with the goal
        check_position(joint, positions[joint.name], "the motion")
        first, last = Motion(q, qd), Motion(positions[joint.name], 0.0)
        limit = max(joint.max_velocity, abs(qd)) * (1.0 + ROUNDING)

        def peak(duration: float, first: Motion = first, last: Motion = last) -> float:
            return Segment(0.0, first, duration, last).peak_velocity()

        if peak(duration) <= limit:
            continue
        enough = max(duration, abs(last.position - q) / limit)
        while peak(enough) > limit:
            enough *= 1.01
        digit = 10.0 ** (math.floor(math.log10(enough)) - 1)
        unit = "m/s" if joint.type is JointType.PRISMATIC else "rad/s"
        raise ControlError(
            f"joint '{joint.name}' needs {peak(duration):.3g} {unit}, "
            f"limit {joint.max_velocity:.3g} {unit}; "
            f"use a duration of at least {math.ceil(enough / digit) * digit:g} s"
        )


def require_speed(speed: float) -> None:
    """Raise ControlError unless ``speed`` is within SLOWEST … 1."""
    if not SLOWEST <= speed <= 1.0:
        raise ControlError(
            f"speed must be in [{SLOWEST}, 1], got {speed}: it is a fraction of the "
            "joints' largest velocities"
        )


def import_planner() -> None:
    """Import the planner, which takes some milliseconds, before a tick needs it."""
    import ruckig  # noqa: F401


def _within_limits(
    joints: Sequence[Joint], start: JointsMotion, ends: Sequence[float], speed: float
) -> ruckig.Trajectory:
    """Plan with ever harder braking until no joint passes its limits."""
    hardness = [1.0] * len(joints)
    motion = None
    for _ in range(1 + _DOUBLINGS):
        found = _solve(joints, start, ends, speed, hardness)
        if found is None:  # by chance, or it would take hours: far too fast
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
    joints: Sequence[Joint], start: JointsMotion, motion: ruckig.Trajectory
) -> list[int]:
    """Return the joints that would pass their limits, or go further beyond them."""
    return [
        k
        for k, (joint, extremes) in enumerate(
            zip(joints, motion.position_extrema, strict=True)
        )
        if joint.type is not JointType.CONTINUOUS
        and not (
            min(joint.limits.lower, start.positions[k]) - ROUNDING <= extremes.min
            and extremes.max <= max(joint.limits.upper, start.positions[k]) + ROUNDING
        )
    ]


def _solve(
    joints: Sequence[Joint],
    start: JointsMotion,
    ends: Sequence[float],
    speed: float,
    hardness: Sequence[float],
) -> ruckig.Trajectory | None:
    """Return the motion; None if the planner's equations fail."""
    import ruckig  # without annotations: its values are Any

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
    # A straight line in joint space where possible.  Synchronizing the joints fails
    # numerically about once in 20000, planning each one separately more rarely.
    for together in (ruckig.Synchronization.Phase, ruckig.Synchronization.No):
        wanted.synchronization = together
        try:
            ruckig.Ruckig(len(joints)).calculate(wanted, motion)
        except (ruckig.RuckigError, ValueError):  # ValueError: a code without a name
            continue
        return motion
    return None


def _jerk_to_stay_below(limit: float, qd: float, qdd: float) -> float:
    """Return the jerk that ends an acceleration before the velocity is too large.

    A goal of a user may accelerate far more than a planned motion.  Were that to end
    with the usual jerk, the joint would gain qdd² / (2 jerk) until then.
    """
    most = max(limit, abs(qd))
    room = max(most - math.copysign(qd, qd * qdd), _LEAST_ROOM * most)
    return _MARGIN * qdd * qdd / (2.0 * room)


def _path(
    joint: Joint, k: int, motion: ruckig.Trajectory, start: float, end: float
) -> list[tuple[float, Motion]]:
    """Return how joint ``k`` moves whenever its jerk changes, SPACING apart."""
    lower, upper = joint.limits.lower, joint.limits.upper
    profile = motion.profiles[0][k]
    changes = list(accumulate([*profile.brake.t, *profile.t]))
    last = max(changes[-1], SPACING)
    path: list[tuple[float, Motion]] = []
    before = 0.0
    for time in changes:
        if time - before >= SPACING and last - time >= SPACING:
            q, qd, qdd = (values[k] for values in motion.at_time(time))
            if joint.type is not JointType.CONTINUOUS:
                q = min(max(q, min(start, lower)), max(start, upper))
            path.append((time, Motion(q, qd, qdd)))
            before = time
    return [*path, (last, Motion(end, 0.0, 0.0))]
