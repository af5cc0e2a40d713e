"""Trajectories as the tick plays them: for each joint a list of segments."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from operator import neg, sub
from typing import final

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
from tool0.control.tolerances import JointTolerances
from tool0.control.track import (
    Piece,
    Stretch,
    Track,
    Way,
    active_index,
    active_piece,
    joined,
    sample_track,
    start_of,
)
from tool0.errors import ControlError, GoalRejectedError


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
    time, motion = leave, Motion(*sample_track(old, leave))
    new = []
    for end, target in points:
        segment = Segment(time, motion, end, target)
        if not segment.is_bounded():
            raise _implausible(segment, motion, target)
        new.append(Piece(segment, goal, tolerances, time - start))
        time, motion = end, target
    return joined(kept, tuple(new))


def splice_long(
    old: Track,
    now: float,
    start: float,
    way: Way,
    suspects: Sequence[int],
    *,
    goal: Goal | None,
    tolerances: JointTolerances,
) -> Track:
    """Return the same as ``splice``, with pieces that are made when they are played.

    Args:
        old: As there.
        now: As there [s].
        start: As there [s].
        way: The points.
        suspects: Which of them, beside the first, may be implausible; the others are
            not looked at.
        goal: As there.
        tolerances: As there.
    """
    leave = max(now, start)
    kept = old[active_index(old, now) : active_index(old, leave) + 1]
    before = leave, Motion(*sample_track(old, leave))
    new = Stretch(before, way, range(len(way)), start, goal, tolerances)
    for number in (0, *suspects):
        segment = new[number].segment
        if not segment.is_bounded():
            _, motion = way[number - 1] if number else before
            raise _implausible(segment, motion, way[number][1])
    return joined(kept, new)


def _implausible(segment: Segment, motion: Motion, target: Motion) -> GoalRejectedError:
    return GoalRejectedError(
        f"no joint can move from {motion} at {segment.start:.6g} s "
        f"to {target} at {segment.end:.6g} s"
    )


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
            piece, following = active_piece(track, time)
            polynomial, change = _play(piece.segment, time)
            polynomials.append(polynomial)
            self.current.append(piece)
            is_last = following == math.inf
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
        earliest = max(start_of(track) for track in self.tracks)
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
