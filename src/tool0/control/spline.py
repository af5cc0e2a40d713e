"""The motion of one joint: polynomial segments through the knots of its trajectories.

Segments are created on demand, so accepting a trajectory with many points takes no
longer than accepting one with a few points.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, final

from tool0.control.tolerances import NO_TOLERANCES, JointTolerances
from tool0.description.model import shortest_turn
from tool0.errors import GoalRejectedError
from tool0.protocol.goals import Goal

Polynomial = tuple[float, ...]
"""``(t0, c0 … c5, 2 c2, 3 c3, 4 c4, 5 c5)``, for Horner's rule.

The argument of the polynomial is ``t = time - t0``.  The coefficients of the velocity
are precomputed, since the tick needs both the position and the velocity.
"""


IMPLAUSIBLE = 1e9
"""Position or velocity that no segment may exceed [rad, rad/s].  The bound keeps sums
in the tick far from overflow; no joint could follow a motion beyond the bound."""


_ALMOST_PI = math.pi - 1e-9


class Motion(NamedTuple):
    """Position, velocity and acceleration of a joint; None for unspecified values."""

    position: float
    velocity: float | None = None
    acceleration: float | None = None
    """Acceleration, which is used only if a velocity is given."""


MotionPlan = Sequence[Sequence[tuple[float, Motion]]]
"""Times [s after the start of the plan] and motions, for each joint."""


class Sample(NamedTuple):
    """Known position, velocity and acceleration of a joint."""

    position: float
    velocity: float
    acceleration: float


@final
class Segment:
    """Lowest-order polynomial on [start, end] that matches the motions at both ends.

    The polynomial is linear if only positions are given, cubic if velocities are also
    given, and quintic if accelerations are also given.  Velocities and accelerations
    are used only if *both* ends specify them.  Before ``start`` and after ``end``, the
    joint rests at the respective end.  A segment of zero duration stays at its start.
    """

    __slots__ = ("coefficients", "end", "start")

    def __init__(self, start: float, first: Motion, end: float, last: Motion) -> None:
        duration = end - start
        if not duration >= 0.0:
            raise GoalRejectedError(
                f"a segment cannot end at {end} s, before its start at {start} s"
            )
        self.start = start
        self.end = end
        self.coefficients = _fit(first, last, duration)

    @staticmethod
    def of(start: float, end: float, polynomial: Sequence[float]) -> Segment:
        """Return the segment with the coefficients c0 … c5 in ``polynomial``."""
        segment = Segment.__new__(Segment)
        c0, c1, c2, c3, c4, c5 = polynomial
        segment.start, segment.end = start, end
        segment.coefficients = c0, c1, c2, c3, c4, c5
        return segment

    def sample(self, time: float) -> Sample:
        """Return the motion at the given ``time`` [s]."""
        if time < self.start:
            return Sample(self.coefficients[0], 0.0, 0.0)
        t = min(time, self.end) - self.start
        c0, c1, c2, c3, c4, c5 = self.coefficients
        position = c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))))
        if time > self.end:
            return Sample(position, 0.0, 0.0)
        return Sample(
            position,
            c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4 + t * 5 * c5))),
            2 * c2 + t * (6 * c3 + t * (12 * c4 + t * 20 * c5)),
        )

    @property
    def polynomial(self) -> Polynomial:
        """The coefficients in the form that is used in the tick."""
        _, _, c2, c3, c4, c5 = self.coefficients
        return (self.start, *self.coefficients, 2 * c2, 3 * c3, 4 * c4, 5 * c5)

    @property
    def rest(self) -> Polynomial:
        """The constant polynomial at the end of the segment."""
        return resting(self.sample(self.end).position)

    def is_bounded(self, bound: float = IMPLAUSIBLE) -> bool:
        """Return whether neither the position nor the speed exceeds ``bound``.

        The absolute values of the terms are summed, so that NaN and overflow are
        treated as unbounded.
        """
        T = self.end - self.start
        c0, c1, c2, c3, c4, c5 = map(abs, self.coefficients)
        position = c0 + T * (c1 + T * (c2 + T * (c3 + T * (c4 + T * c5))))
        speed = c1 + T * (2 * c2 + T * (3 * c3 + T * (4 * c4 + T * 5 * c5)))
        return position <= bound and speed <= bound


def resting(position: float) -> Polynomial:
    """Return the constant polynomial at ``position``."""
    return (0.0, position, *[0.0] * 9)


def stop_ramp(time: float, now: Sample, duration: float) -> tuple[Motion, Motion]:
    """Return the start and the end of the quintic that brings a joint to rest.

    As in ROS, the ramp is the first half of the symmetric quintic that changes the
    velocity from v to -v over twice the ``duration``.  The ramp ends at the turning
    point of the symmetric quintic, at ``position + 5/8 v duration``.
    """
    position, velocity, _ = now
    first = Motion(position, velocity, 0.0)
    there_and_back = Segment(
        time, first, time + 2.0 * duration, Motion(position, -velocity, 0.0)
    )
    return first, Motion(*there_and_back.sample(time + duration))


def _fit(
    first: Motion, last: Motion, T: float
) -> tuple[float, float, float, float, float, float]:
    p0, v0, a0 = first
    p1, v1, a1 = last
    if v0 is None or v1 is None:
        return (p0, (p1 - p0) / T if T > 0.0 else 0.0, 0.0, 0.0, 0.0, 0.0)
    d = p1 - p0
    if a0 is None or a1 is None:
        if not T > 0.0:
            return (p0, v0, 0.0, 0.0, 0.0, 0.0)
        c2 = (3.0 * d - (2.0 * v0 + v1) * T) / T / T
        c3 = (-2.0 * d + (v0 + v1) * T) / T / T / T
        return (p0, v0, c2, c3, 0.0, 0.0)
    if not T > 0.0:
        return (p0, v0, 0.5 * a0, 0.0, 0.0, 0.0)
    vT, v1T, a0TT, a1TT = v0 * T, v1 * T, a0 * T * T, a1 * T * T
    c3 = (20.0 * d - (12.0 * vT + 8.0 * v1T) - (3.0 * a0TT - a1TT)) / 2 / T / T / T
    c4 = (-30.0 * d + 16.0 * vT + 14.0 * v1T + 3.0 * a0TT - 2.0 * a1TT) / 2
    c5 = (12.0 * d - 6.0 * (vT + v1T) - (a0TT - a1TT)) / 2
    return (p0, v0, 0.5 * a0, c3, c4 / T / T / T / T, c5 / T / T / T / T / T)


def wrap_offset(previous: float, following: float) -> float:
    """Return the whole turns that move ``following`` closest to ``previous`` [rad].

    If the two angles are half a turn apart (within 1e-9 rad), the larger angle
    determines the direction of the turn.  Rounding errors therefore do not affect the
    direction.
    """
    turn = shortest_turn(previous, following)
    if abs(turn) > _ALMOST_PI:
        turn = math.copysign(turn, following - previous)
    return previous + turn - following


class Knots(NamedTuple):
    """The knots of one joint: motions and their times."""

    times: Sequence[float]
    """Times after the start of the trajectory [s], in increasing order."""
    motion: Callable[[int], Motion]
    """Function that returns the motion at a knot, by index."""
    is_stepped: bool = False
    """Whether the joint jumps to each knot at the time of the previous knot, instead of
    moving there."""

    def segment(
        self, begin: float, origin: Motion, start: float, number: int, *, first: bool
    ) -> Segment:
        """Return the segment from ``origin`` to a knot of the trajectory.

        ``begin`` and ``start`` [s] are the start times of the segment and the
        trajectory. A stepped segment rests at its knot, or at its origin if it is the
        ``first``.
        """
        end, motion = start + self.times[number], self.motion(number)
        if not self.is_stepped:
            return Segment(begin, origin, end, motion)
        position = origin.position if first else motion.position
        return Segment.of(begin, end, (position, 0.0, 0.0, 0.0, 0.0, 0.0))

    @staticmethod
    def of(path: Sequence[tuple[float, Motion]]) -> Knots:
        """Return the knots for a path of times [s] and motions.

        The path must contain at least one knot.
        """
        times, motions = zip(*path, strict=True)
        return Knots(times, motions.__getitem__)


class SplineSection(NamedTuple):
    """Segments through the knots of one trajectory.

    Segment k leads to knot k, from knot k - 1 or, if k is ``first``, from ``origin``.
    """

    start: float
    """Start time of the trajectory [s]."""
    knots: Knots
    first: int
    """Index of the knot at the end of the segment from ``origin``."""
    origin: tuple[float, Motion]
    """Time [s] and motion at the start of the first segment."""
    span: range
    """Indices of the remaining segments; there is at least one segment."""
    goal: Goal | None
    """The goal to which the tolerances apply."""
    tolerances: JointTolerances
    made: Mapping[int, Segment]
    """Segments that were created when the trajectory was accepted, by index."""

    @property
    def begin(self) -> float:
        """Start of the first remaining segment [s]."""
        number = self.span[0]
        if number == self.first:
            return self.origin[0]
        return self.start + self.knots.times[number - 1]

    def active_number(self, time: float) -> int:
        """Return the index of the remaining segment that is closest to ``time`` [s]."""
        # Only the times at which one segment follows another are relevant.
        return bisect_right(
            self.knots.times,
            time,
            self.span[0],
            self.span[-1],
            key=self.start.__add__,
        )

    def between(self, begin: float, end: float) -> SplineSection:
        """Return the section, restricted to the segments between two times [s]."""
        span = range(self.active_number(begin), self.active_number(end) + 1)
        return self if span == self.span else self._replace(span=span)

    def segment(self, number: int) -> Segment:
        """Return the segment with the index ``number``."""
        made = self.made.get(number)
        if made is not None:
            return made
        knots, is_first = self.knots, number == self.first
        begin, origin = self.origin
        if not is_first:
            begin = self.start + knots.times[number - 1]
            origin = knots.motion(number - 1)
        return knots.segment(begin, origin, self.start, number, first=is_first)


class JointSpline(NamedTuple):
    """The motion of one joint.

    Each section is active until the next one begins, and so is each segment.  Before
    the first segment and after the last segment, the joint is at rest.
    """

    sections: tuple[SplineSection, ...]
    """The sections, in order; there is at least one section."""

    @property
    def begin(self) -> float:
        """Start of the first segment [s]."""
        return self.sections[0].begin

    @property
    def end(self) -> float:
        """End of the last segment [s]."""
        return self._last_segment().end

    @property
    def target(self) -> float:
        """The joint's final position [rad | m]."""
        last = self._last_segment()
        return last.sample(last.end).position

    def _last_segment(self) -> Segment:
        section = self.sections[-1]
        return section.segment(section.span[-1])

    def active(self, time: float) -> tuple[SplineSection, Segment, float]:
        """Return the section and the segment at ``time``, and the next start time [s].

        The next start time is the start of the next segment; it is inf for the last
        segment.
        """
        number = self._active_section(time)
        section = self.sections[number]
        index = section.active_number(time)
        segment = section.segment(index)
        if index != section.span[-1]:
            return section, segment, segment.end
        if number + 1 == len(self.sections):
            return section, segment, math.inf
        return section, segment, self.sections[number + 1].begin

    def _active_section(self, time: float) -> int:
        number = len(self.sections) - 1
        while number > 0 and self.sections[number].begin > time:
            number -= 1
        return number

    def sample(self, time: float) -> Sample:
        """Return the desired motion at ``time`` [s]."""
        return self.active(time)[1].sample(time)

    def with_goal(self, goal: Goal | None) -> JointSpline:
        """Return a copy of the motion, with all sections assigned to ``goal``."""
        return JointSpline(
            tuple(section._replace(goal=goal) for section in self.sections)
        )

    def spliced(
        self,
        now: float,
        start: float,
        knots: Knots,
        *,
        first: int = 0,
        suspects: Sequence[int],
        goal: Goal | None = None,
        tolerances: JointTolerances = NO_TOLERANCES,
    ) -> JointSpline:
        """Return a spline of the motion up to ``start``, a bridge, and a new motion.

        Args:
            now: Time from which the spline is needed [s].
            start: Start time of the new trajectory [s].
            knots: Knots of the new trajectory.
            first: Index of the first knot that is used, which is after ``now`` and
                ``start``.
            suspects: Indices of segments after the bridge that may be implausible.
            goal: Goal to which the tolerances on the new segments apply.
            tolerances: Tolerances on the new segments.

        The bridge starts from the old *desired* motion, at ``start`` or ``now``,
        whichever is later.  As in ROS, the first knot determines the polynomial order
        of the bridge.

        Raises:
            GoalRejectedError: If a segment is implausible.
        """
        leave = max(now, start)
        origin = leave, Motion(*self.sample(leave))
        section = section_through(
            start,
            knots,
            origin,
            first=first,
            suspects=suspects,
            goal=goal,
            tolerances=tolerances,
        )
        return self.followed_by(section, now, leave)

    def followed_by(
        self, section: SplineSection, now: float, leave: float
    ) -> JointSpline:
        """Return the motion from ``now`` to ``leave`` [s], followed by a section."""
        kept = self.sections[
            self._active_section(now) : self._active_section(leave) + 1
        ]
        return JointSpline((*(each.between(now, leave) for each in kept), section))


def section_through(
    start: float,
    knots: Knots,
    origin: tuple[float, Motion],
    *,
    first: int,
    suspects: Sequence[int],
    goal: Goal | None = None,
    tolerances: JointTolerances = NO_TOLERANCES,
) -> SplineSection:
    """Return the segments from ``origin`` through the knots, starting at ``first``.

    Args:
        start: Start time of the trajectory [s].
        knots: Knots of the trajectory.
        origin: Time [s] and motion at the start of the first segment.
        first: Index of the knot at the end of the first segment.
        suspects: Indices of later segments that may be implausible.
        goal: Goal to which the tolerances apply.
        tolerances: Tolerances on the segments.

    Raises:
        GoalRejectedError: If a segment is implausible.
    """
    made: dict[int, Segment] = {}
    last, (time, motion) = first - 1, origin
    for number in (first, *suspects):
        if number != last + 1:
            time, motion = start + knots.times[number - 1], knots.motion(number - 1)
        segment = knots.segment(time, motion, start, number, first=number == first)
        made[number] = segment
        end, target = segment.end, knots.motion(number)
        if not segment.is_bounded():
            raise GoalRejectedError(
                f"no joint can move from {motion} at {time:.6g} s "
                f"to {target} at {end:.6g} s"
            )
        last, time, motion = number, end, target
    span = range(first, len(knots.times))
    return SplineSection(start, knots, first, origin, span, goal, tolerances, made)


def point_to_point(
    time: float,
    origin: Motion,
    duration: float,
    target: Motion,
    goal: Goal | None = None,
) -> JointSpline:
    """Return the spline of one segment that starts at ``time`` [s]."""
    knots = Knots((duration,), lambda _: target)
    start = time, origin
    return JointSpline(
        (SplineSection(time, knots, 0, start, range(1), goal, NO_TOLERANCES, {}),)
    )


def along(segment: Segment) -> JointSpline:
    """Return the spline of one segment, which has no goal."""
    return through([segment], [segment.end - segment.start])


def through(segments: Sequence[Segment], times: Sequence[float]) -> JointSpline:
    """Return the spline of consecutive segments, which have no goal.

    ``times`` are the end times of the segments, relative to the start of the first
    segment [s].
    """
    start = segments[0].start
    origin = start, Motion(*segments[0].sample(start))
    ends = [Motion(*segment.sample(segment.end)) for segment in segments]
    made = dict(enumerate(segments))
    span = range(len(segments))
    knots = Knots(times, ends.__getitem__)
    return JointSpline(
        (SplineSection(start, knots, 0, origin, span, None, NO_TOLERANCES, made),)
    )


def hold(time: float, position: float, goal: Goal | None = None) -> JointSpline:
    """Return the spline of a joint that rests at ``position`` after ``time`` [s]."""
    rest = Motion(position, 0.0, 0.0)
    return point_to_point(time, rest, 0.0, rest, goal)


def stop(
    time: float,
    now: Sample,
    duration: float,
    clamp: Callable[[float], float],
    goal: Goal | None = None,
) -> JointSpline:
    """Return the spline of a stop that ends within the joint's limits.

    Within the limits, the stop is the same as in ROS.
    """
    first, last = stop_ramp(time, now, duration)
    ramp = Segment(time, first, time + duration, last)
    position = ramp.sample(ramp.end).position
    if clamp(position) != position:
        last = Motion(clamp(position), 0.0, 0.0)
    return point_to_point(time, first, duration, last, goal)
