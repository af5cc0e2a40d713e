"""What one joint is to do: pieces one after the other, made at once or when played."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import NamedTuple, TypeAlias, final, overload

from tool0.control.goal import Goal
from tool0.control.point_survey import MANY
from tool0.control.segment import Motion, Sample, Segment
from tool0.control.tolerances import NO_TOLERANCES, JointTolerances
from tool0.control.trajectory import TrajectoryPoint


class Piece(NamedTuple):
    """One joint's segment, and the goal whose tolerances hold while it is played."""

    segment: Segment
    goal: Goal | None = None
    tolerances: JointTolerances = NO_TOLERANCES
    time_from_start: float = 0.0
    """Start of the segment after the start of its trajectory [s]."""


def motion_of(point: TrajectoryPoint, column: int, offset: float | None) -> Motion:
    """Return what a point wants of one joint.

    Args:
        point: The point.
        column: Which of its numbers are the joint's.
        offset: What is added to the position [rad], for a continuous joint.
    """
    position = point.positions[column]
    return Motion(
        position if offset is None else position + offset,
        point.velocities[column] if point.velocities else None,
        point.accelerations[column] if point.accelerations else None,
    )


@final
@dataclass(frozen=True, slots=True)
class Way:
    """Times and motions of one joint at many points, made when they are asked for."""

    times: Sequence[float]
    """When to be at the points [s]."""
    points: Sequence[TrajectoryPoint]
    column: int
    """Which of the points' numbers are the joint's."""
    offset: float | None
    """What is added to the positions: whole turns of a continuous joint [rad]."""

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, number: int) -> tuple[float, Motion]:
        motion = motion_of(self.points[number], self.column, self.offset)
        return self.times[number], motion


@final
@dataclass(frozen=True, slots=True)
class Stretch(Sequence[Piece]):
    """Pieces along a way.  Each is made when it is asked for."""

    before: tuple[float, Motion]
    """Start of the way: its time [s] and the motion there."""
    way: Way
    span: range
    """To which of the points of the way these pieces lead."""
    start: float
    """When the trajectory starts [s]."""
    goal: Goal | None
    tolerances: JointTolerances

    @property
    def begin(self) -> float:
        """Start of the first piece [s]."""
        first = self.span[0]
        return self.way.times[first - 1] if first else self.before[0]

    def __len__(self) -> int:
        return len(self.span)

    @overload
    def __getitem__(self, index: int) -> Piece: ...

    @overload
    def __getitem__(self, index: slice) -> Stretch: ...

    def __getitem__(self, index: int | slice) -> Piece | Stretch:
        if isinstance(index, slice):
            return replace(self, span=self.span[index])
        return self._piece(self.span[index])

    def _piece(self, number: int) -> Piece:
        """Return the piece that leads to a point of the way."""
        time, motion = self.way[number - 1] if number else self.before
        end, target = self.way[number]
        segment = Segment(time, motion, end, target)
        return Piece(segment, self.goal, self.tolerances, time - self.start)

    def active_index(self, time: float) -> int:
        """Return the last piece that started before or at ``time``, or the first.

        Each but the first starts when the one before it ends.
        """
        return self._active_number(time) - self.span[0]

    def active_piece(self, time: float) -> tuple[Piece, float]:
        """Return that piece, and when the next one starts [s]; never, if inf."""
        number = self._active_number(time)
        piece = self._piece(number)
        return piece, math.inf if number == self.span[-1] else piece.segment.end

    def _active_number(self, time: float) -> int:
        return bisect_right(self.way.times, time, self.span[0], self.span[-1])


Part: TypeAlias = tuple[Piece, ...] | Stretch


@final
@dataclass(frozen=True, slots=True)
class LongTrack(Sequence[Piece]):
    """Pieces of which many are made only when they are asked for."""

    parts: tuple[Part, ...]
    """None of them is empty."""

    def __len__(self) -> int:
        return sum(map(len, self.parts))

    @overload
    def __getitem__(self, index: int) -> Piece: ...

    @overload
    def __getitem__(self, index: slice) -> Track: ...

    def __getitem__(self, index: int | slice) -> Piece | Track:
        if isinstance(index, slice):
            return self._slice(range(len(self))[index])
        index = range(len(self))[index]
        number = 0
        while index >= len(self.parts[number]):
            index -= len(self.parts[number])
            number += 1
        return self.parts[number][index]

    def active_index(self, time: float) -> int:
        """Return the last piece that started before or at ``time``, or the first."""
        number = self._active_part(time)
        before = sum(map(len, self.parts[:number]))
        return before + active_index(self.parts[number], time)

    def active_piece(self, time: float) -> tuple[Piece, float]:
        """Return that piece, and when the next one starts [s]; never, if inf."""
        if start_of(self.parts[-1]) <= time:  # as almost always
            return active_piece(self.parts[-1], time)
        number = self._active_part(time)
        piece, following = active_piece(self.parts[number], time)
        if following == math.inf and number + 1 < len(self.parts):
            following = start_of(self.parts[number + 1])
        return piece, following

    def _active_part(self, time: float) -> int:
        return max(bisect_right(self.parts, time, key=start_of) - 1, 0)

    def _slice(self, wanted: range) -> Track:
        if len(wanted) < MANY or wanted.step != 1:
            return tuple(map(self.__getitem__, wanted))
        parts, before = [], 0
        for part in self.parts:
            some = part[max(wanted.start - before, 0) : max(wanted.stop - before, 0)]
            if some:
                parts.append(some)
            before += len(part)
        return LongTrack(tuple(parts))


Track: TypeAlias = tuple[Piece, ...] | LongTrack
"""The pieces of one joint; each is active from its start to the next one's."""

_piece_start = attrgetter("segment.start")


def start_of(track: Part | LongTrack) -> float:
    """Return when the first piece of the track starts [s]."""
    if isinstance(track, Stretch):  # need not make the piece
        return track.begin
    return track[0].segment.start


def active_index(track: Part | LongTrack, time: float) -> int:
    """Return the last piece that started before or at ``time``, or the first."""
    if isinstance(track, tuple):
        return (bisect_right(track, time, key=_piece_start) or 1) - 1
    return track.active_index(time)


def active_piece(track: Part | LongTrack, time: float) -> tuple[Piece, float]:
    """Return that piece, and when the next one starts [s]; never, if inf."""
    if not isinstance(track, tuple):
        return track.active_piece(time)
    following = bisect_right(track, time, key=_piece_start) or 1
    piece = track[following - 1]
    if following == len(track):
        return piece, math.inf
    return piece, track[following].segment.start


def sample_track(track: Track, time: float) -> Sample:
    """Return what the track wants of its joint at ``time``."""
    return active_piece(track, time)[0].segment.sample(time)


def joined(before: Track, after: Part) -> Track:
    """Return one track after the other."""
    if isinstance(before, tuple) and isinstance(after, tuple):
        return before + after
    parts = (before,) if isinstance(before, tuple) else before.parts
    return LongTrack((*parts, after))


def with_goal(track: Track, goal: Goal | None) -> Track:
    """Return the same pieces, as those of ``goal``."""
    if isinstance(track, tuple):
        return tuple(piece._replace(goal=goal) for piece in track)
    return LongTrack(
        tuple(
            replace(part, goal=goal)
            if isinstance(part, Stretch)
            else tuple(piece._replace(goal=goal) for piece in part)
            for part in track.parts
        )
    )
