"""Timing of moves, which determines the speed along each part of a segment."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from tool0.description.model import Joint
from tool0.errors import UnreachableError
from tool0.motion.line import LinePath
from tool0.motion.moves import Move, Tail, WarningKind
from tool0.motion.path import Cubics
from tool0.motion.profile import SpeedProfile, braking, smoothed, trapezoid
from tool0.motion.rules import MoveRules
from tool0.motion.segments import (
    JointSegment,
    PathSegment,
    ToolSegment,
    distance_within,
    passage,
)

_RAMP_SHARE = 0.25
"""Fraction of a specified duration for each ramp from rest or to rest."""
LONGEST = 1e6
"""Maximum duration of a move [s], which is 11 days."""
_ROUNDS = 16
_ROUNDING = 1e-9
_SPEED_SHARE = 0.999
"""Fraction of a joint's maximum velocity that plans use. The joint may be slightly
faster between two knots."""
_SHORTEST = 2e-4
"""Minimum length of an interval for a check of the acceleration [s]. Rounding errors
are too large in shorter intervals."""


@final
class ArmLimits:
    """Limits of an arm's joints."""

    def __init__(self, joints: tuple[Joint, ...], rules: MoveRules) -> None:
        self.rules = rules
        self.names = tuple(joint.name for joint in joints)
        velocities = [joint.max_velocity for joint in joints]
        self.fastest = _SPEED_SHARE * np.array(velocities)
        """Maximum joint velocities in plans [rad/s], shape (6,)."""
        self.strongest = np.array(rules.accelerations)
        """Maximum accelerations of the joints [rad/s²], shape (6,)."""
        self.braking = np.array([joint.max_acceleration for joint in joints])
        """Accelerations that are always allowed in blends between moves [rad/s²], shape
        (6,)."""

    def excess(self, motion: Cubics) -> tuple[float, float, int]:
        """Return velocity and acceleration relative to limits, and the worst joint."""
        times, q, qd = motion
        ratios = (np.abs(qd) / self.fastest).max(axis=0)
        h = np.diff(times)
        long = h > _SHORTEST
        h, change = h[long, None], np.diff(q, axis=0)[long]
        before, after = qd[:-1][long], qd[1:][long]
        first = 6.0 * change / h - 4.0 * before - 2.0 * after
        last = 2.0 * before + 4.0 * after - 6.0 * change / h
        accelerations = np.maximum(np.abs(first), np.abs(last)) / h
        strongest = float((accelerations / self.strongest).max(initial=0.0))
        return float(ratios.max()), strongest, int(ratios.argmax())


class TimingWarning(NamedTuple):
    """Deviation of a move from the request."""

    kind: WarningKind
    text: str


class _Speeds(NamedTuple):
    speed: float
    acceleration: float


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TimedSegment:
    """Timing of the part of a segment between the blends at both ends."""

    segment: PathSegment
    zone_in: float
    """Length of the blend from the previous move, in x; 0 for a start from rest."""
    zone_out: float
    """Length of the blend to the next move, in x; 0 for a stop at the end."""
    profile: SpeedProfile
    """Speed profile between the blends."""
    acceleration: float
    motion: Cubics
    """Motion between the blends."""
    radius: float
    """Blend radius at the end of the move [m], which may have been reduced."""
    warnings: tuple[TimingWarning, ...]

    @property
    def speed_in(self) -> float:
        return float(self.profile.speeds[0])

    @property
    def speed_out(self) -> float:
        return float(self.profile.speeds[-1])


def timed_segment(
    segment: PathSegment,
    move: Move,
    tail: Tail | None,
    limits: ArmLimits,
    *,
    entry: float = 1.0,
    is_symmetric: bool = False,
) -> TimedSegment:
    """Return the fastest motion along a segment within the limits.

    Args:
        segment: Path of the move.
        move: Move with the requested speeds and the blend radius.
        tail: End of the previous move, with which to blend; None for a start from rest.
        limits: Limits of the joints.
        entry: Fraction of the move's speed that is allowed directly after the blend.
        is_symmetric: Whether the blend must not be longer than the tail.

    Raises:
        UnreachableError: If the move would have to be extremely slow, or would take
            days.
    """
    warnings: list[TimingWarning] = []
    zone_in, zone_out, scale = _zones(segment, move, tail)
    if scale < 1.0:
        text = f"overlapping blends: the radius is reduced to {scale:.0%}"
        warnings.append(TimingWarning("blend", text))
    if tail is not None and is_symmetric:
        zone_in = min(zone_in, tail.remaining)
    n_rests = (tail is None) + (move.r == 0.0)
    speed, acceleration = wanted = _speeds(segment, move, n_rests, limits)
    harder_in, harder_out = _end_accelerations(segment, limits)
    inner = max(segment.length - zone_in - zone_out, 0.0)
    joint, remedy = 0, limits.rules.remedy
    for k in range(_ROUNDS):
        out = min(speed, math.sqrt(2.0 * max(acceleration, harder_out) * zone_out))
        into = min(
            speed,
            math.sqrt(2.0 * max(acceleration, harder_in) * zone_in),
            math.sqrt(out**2 + 2.0 * acceleration * inner),
        )
        into *= entry
        out = min(out, math.sqrt(into**2 + 2.0 * acceleration * inner))
        profile = trapezoid(inner, speed, acceleration, into, out)
        if limits.rules.smoothing and into == out == 0.0:
            profile = smoothed(profile, limits.rules.smoothing)
        if not profile.duration <= LONGEST:
            raise UnreachableError(
                f"the move would take more than {LONGEST:g} s; give it more speed and "
                "acceleration"
            )
        motion = passage(segment, profile, zone_in)
        too_fast, too_strong, joint = limits.excess(motion)
        if zone_out > 0.0:  # the arm may have to stop at the end
            stop = braking(zone_out, out, acceleration)
            stopping = passage(segment, stop, segment.length - zone_out)
            worse = limits.excess(stopping)
            joint = worse[2] if worse[0] > too_fast else joint
            too_fast = max(too_fast, worse[0])
            too_strong = max(too_strong, worse[1])
        if max(too_fast, too_strong) <= 1.0 + limits.rules.excess:
            break
        slower = max(too_fast, math.sqrt(too_strong), 1.0)
        speed = min(speed, profile.peak) / slower
        if too_strong > 1.0 or k >= _ROUNDS // 4:
            acceleration /= slower**2
        if speed < limits.rules.slowest * min(wanted.speed, profile.peak):
            raise UnreachableError(
                f"the path passes a singularity: joint '{limits.names[joint]}' would "
                f"have to turn {too_fast:.0f} times as fast as it can; {remedy}"
            )
    else:
        raise UnreachableError(f"the path passes too close to a singularity; {remedy}")
    if speed < wanted.speed * (1.0 - _ROUNDING) and k > 0:
        text = (
            f"at most {speed:.4g} instead of {wanted.speed:.4g} per second: joint "
            f"'{limits.names[joint]}' would be too fast"
        )
        warnings.append(TimingWarning("speed", text))
    return TimedSegment(
        segment=segment,
        zone_in=zone_in,
        zone_out=zone_out,
        profile=profile,
        acceleration=acceleration,
        motion=motion,
        radius=move.r * scale,
        warnings=tuple(warnings),
    )


def is_straight(segment: PathSegment) -> bool:
    """Return whether the tool moves along a straight line."""
    return (
        isinstance(segment, ToolSegment)
        and isinstance(segment.path, LinePath)
        and segment.path.length > 1e-6
    )


def _zones(
    segment: PathSegment, move: Move, tail: Tail | None
) -> tuple[float, float, float]:
    """Return the lengths of both blends, and the factor for the blend radius."""
    length = segment.length
    into = out = 0.0
    if tail is not None:
        into = distance_within(segment, tail.radius, at_end=False)
    if move.r > 0.0:
        out = distance_within(segment, move.r, at_end=True)
    # For a start from rest or a stop, half of the segment remains for the change of
    # speed.
    most = length if into > 0.0 and out > 0.0 else length / 2.0
    scale = min(1.0, most / max(into + out, 1e-300))
    return into * scale, out * scale, scale


def _speeds(
    segment: PathSegment, move: Move, n_rests: int, limits: ArmLimits
) -> _Speeds:
    """Return the speed and acceleration that a move requests."""
    speed, acceleration = move.v, move.a
    if move.t > 0.0:
        speed = segment.length / (move.t * (1.0 - _RAMP_SHARE * n_rests / 2.0))
        acceleration = speed / (move.t * _RAMP_SHARE)
    if isinstance(segment, JointSegment):
        rate = np.maximum(np.abs(segment.rate), 1e-12)
        speed = min(speed, float((limits.fastest / rate).min()))
        acceleration = min(acceleration, float((limits.strongest / rate).min()))
    return _Speeds(speed, acceleration)


def _end_accelerations(segment: PathSegment, limits: ArmLimits) -> tuple[float, float]:
    """Return the path accelerations that the joints allow at both ends of the path."""
    _, rates = segment.at(np.array([0.0, segment.length]))
    allowed = (limits.braking / np.maximum(np.abs(rates), 1e-12)).min(axis=1)
    return float(allowed[0]), float(allowed[1])
