"""Trajectories as the tick plays them: for each joint a list of segments."""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Sequence
from operator import neg, sub
from typing import NamedTuple, final

from tool0.control.goal import Goal
from tool0.control.segment import (
    Motion,
    Polynomial,
    Sample,
    Segment,
    hold,
    resting,
    stop_ramp,
)
from tool0.control.tolerances import NO_TOLERANCES, JointTolerances
from tool0.errors import ControlError, GoalRejectedError

IMPLAUSIBLE = 1e9
"""No segment may be able to reach this position or velocity [rad, rad/s]: the sums of
the tick stay far from overflow, and no joint could follow anyway."""


class Piece(NamedTuple):
    """One joint's segment, and the goal whose tolerances hold while it is played."""

    segment: Segment
    goal: Goal | None = None
    tolerances: JointTolerances = NO_TOLERANCES
    time_from_start: float = 0.0
    """Start of the segment after the start of its trajectory [s]."""


Track = tuple[Piece, ...]
"""The pieces of one joint; each is active from its start to the next one's."""


def active_index(track: Track, time: float) -> int:
    """Return the last piece that starts at or before ``time``, at least the first."""
    starts = [piece.segment.start for piece in track]
    return max(bisect.bisect_right(starts, time) - 1, 0)


def sample_track(track: Track, time: float) -> Sample:
    """Return what the track wants of its joint at ``time``."""
    return track[active_index(track, time)].segment.sample(time)


def hold_track(time: float, position: float, goal: Goal | None = None) -> Track:
    """Return the track of resting at ``position`` from ``time`` on."""
    return (Piece(hold(time, position), goal),)


def stop_track(
    time: float,
    now: Sample,
    duration: float,
    clamp: Callable[[float], float],
    goal: Goal | None = None,
) -> Track:
    """Return the track that slows down as ROS does, but not beyond the limits."""
    segment = stop_ramp(time, now, duration)
    end = segment.sample(segment.end).position
    if clamp(end) != end:
        first, last = Motion(now[0], now[1], 0.0), Motion(clamp(end), 0.0, 0.0)
        segment = Segment(time, first, segment.end, last)
    return (Piece(segment, goal),)


def splice(
    old: Track,
    now: float,
    start: float,
    points: Sequence[tuple[float, Motion]],
    *,
    goal: Goal | None,
    tolerances: JointTolerances,
) -> Track:
    """Return the old motion up to ``start``, a bridge, and the new motion.

    Args:
        old: What is played so far.
        now: The time from which on the track is needed [s].
        start: When the new trajectory starts [s].
        points: Absolute time [s] and motion, all after ``now`` and ``start``.
        goal: Whose tolerances hold on the new pieces.
        tolerances: Those tolerances.

    The bridge leaves the old *desired* motion, at ``start`` or ``now``, whichever is
    later; its order is set by the first point, as in ROS.
    """
    leave = max(now, start)
    kept = old[active_index(old, now) : active_index(old, leave) + 1]
    motion = Motion(*sample_track(old, leave))
    time = leave
    new = []
    for end, target in points:
        segment = Segment(time, motion, end, target)
        if not segment.is_bounded(IMPLAUSIBLE):
            raise GoalRejectedError(
                f"no joint can move from {motion} at {time:.6g} s "
                f"to {target} at {end:.6g} s"
            )
        new.append(Piece(segment, goal, tolerances, time - start))
        time, motion = end, target
    return (*kept, *new)


@final
class Playback:
    """Tracks with a cursor: ``advance`` at a change, ``errors`` in every tick."""

    __slots__ = (
        "_moving",
        "_polynomials",
        "_rest",
        "_zeros",
        "arrived",
        "current",
        "next_change",
        "tracks",
    )

    def __init__(self, tracks: Sequence[Track], time: float) -> None:
        self.tracks = tuple(tracks)
        self.advance(time)

    def advance(self, time: float) -> None:
        """Find the pieces that are active at ``time``, and when that changes."""
        self.current: list[Piece] = []
        self.arrived: list[bool] = []
        """Whether the joint is at the end of its last piece."""
        self.next_change = math.inf
        """When to call ``advance`` again [s]."""
        polynomials: list[Polynomial] = []
        for track in self.tracks:
            index = active_index(track, time)
            piece = track[index]
            is_last = index + 1 == len(track)
            following = math.inf if is_last else track[index + 1].segment.start
            polynomial, change = _play(piece.segment, time)
            polynomials.append(polynomial)
            self.current.append(piece)
            self.arrived.append(is_last and time >= piece.segment.end)
            self.next_change = min(self.next_change, change, following)
        self._polynomials = list(enumerate(polynomials))
        self._moving = any(polynomial[2:] != _STILL for polynomial in polynomials)
        self._rest = [polynomial[1] for polynomial in polynomials]
        self._zeros = [0.0] * len(polynomials)

    def errors(
        self, time: float, positions: Sequence[float], velocities: Sequence[float]
    ) -> tuple[list[float], list[float]]:
        """Return desired minus measured positions, and the same of velocities."""
        if not self._moving:
            return list(map(sub, self._rest, positions)), list(map(neg, velocities))
        errors: list[float] = []
        rates: list[float] = []
        for k, (t0, c0, c1, c2, c3, c4, c5, d2, d3, d4, d5) in self._polynomials:
            t = time - t0
            position = c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))))
            errors.append(position - positions[k])
            velocity = c1 + t * (d2 + t * (d3 + t * (d4 + t * d5)))
            rates.append(velocity - velocities[k])
        return errors, rates

    def desired(self, time: float) -> tuple[list[float], list[float]]:
        """Return the desired positions and velocities."""
        return self.errors(time, self._zeros, self._zeros)

    def motions(self, time: float) -> list[Sample]:
        """Return what is wanted of every joint at any ``time`` the tracks cover."""
        earliest = max(track[0].segment.start for track in self.tracks)
        if not time >= earliest:
            raise ControlError(
                f"no trajectory is known for {time} s, the oldest starts at {earliest}"
            )
        return [sample_track(track, time) for track in self.tracks]


_STILL = resting(0.0)[2:]


def _play(segment: Segment, time: float) -> tuple[Polynomial, float]:
    """Return the polynomial for ``time``, and until when it holds."""
    if time < segment.start:
        return resting(segment.coefficients[0]), segment.start
    if time < segment.end:
        return segment.polynomial, segment.end
    if time == segment.end:
        return segment.polynomial, math.nextafter(time, math.inf)
    return segment.rest, math.inf
