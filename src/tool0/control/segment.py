"""Polynomial motion of one joint between two instants, and angles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, final

from tool0.errors import GoalRejectedError

Polynomial = tuple[float, ...]
"""``(t0, c0 … c5, 2 c2, 3 c3, 4 c4, 5 c5)``: position and velocity by Horner's rule.

``t = time - t0``; the velocity's coefficients are ready, since the tick wants both.
"""


IMPLAUSIBLE = 1e9
"""No segment may be able to reach this position or velocity [rad, rad/s]: the sums of
the tick stay far from overflow, and no joint could follow anyway."""


_ALMOST_PI = math.pi - 1e-9


class Motion(NamedTuple):
    """Where a joint is, and how it moves; None for what is not prescribed."""

    position: float
    velocity: float | None = None
    acceleration: float | None = None
    """Counts only beside a velocity."""


MotionPlan = Sequence[Sequence[tuple[float, Motion]]]
"""For each joint, how it is to move when [s after the start of the plan]."""


class Sample(NamedTuple):
    """A motion of which everything is known."""

    position: float
    velocity: float
    acceleration: float


@final
class Segment:
    """The lowest polynomial on [start, end] that meets both motions.

    Linear for positions, cubic with velocities, quintic with accelerations as well:
    the order is what *both* ends prescribe.  Before ``start`` and after ``end`` the
    joint rests at the respective end.  A segment without duration keeps to its start.
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

    def sample(self, time: float) -> Sample:
        """Return the motion at ``time``."""
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
        """The coefficients as the tick reads them."""
        _, _, c2, c3, c4, c5 = self.coefficients
        return (self.start, *self.coefficients, 2 * c2, 3 * c3, 4 * c4, 5 * c5)

    @property
    def rest(self) -> Polynomial:
        """The polynomial of resting at the end."""
        return resting(self.sample(self.end).position)

    def is_bounded(self, bound: float = IMPLAUSIBLE) -> bool:
        """Return whether neither position nor speed can exceed ``bound``.

        Sums the terms' sizes, so that NaN and overflow count as unbounded.
        """
        T = self.end - self.start
        c0, c1, c2, c3, c4, c5 = map(abs, self.coefficients)
        position = c0 + T * (c1 + T * (c2 + T * (c3 + T * (c4 + T * c5))))
        speed = c1 + T * (2 * c2 + T * (3 * c3 + T * (4 * c4 + T * 5 * c5)))
        return position <= bound and speed <= bound


def resting(position: float) -> Polynomial:
    """Return the polynomial of staying at ``position``."""
    return (0.0, position, *[0.0] * 9)


def stop_ramp(time: float, now: Sample, duration: float) -> tuple[Motion, Motion]:
    """Return the ends of the quintic that brings a moving joint to rest.

    As in ROS it ends after ``duration``, where the symmetric quintic from velocity v to
    -v over twice the duration turns round, at ``position + 5/8 v duration``.
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


def shortest_turn(start: float, end: float) -> float:
    """Return the shortest turn from ``start`` to ``end``, in (-π, π] [rad]."""
    turn = math.remainder(end - start, math.tau)
    return math.pi if turn == -math.pi else turn


def wrap_offset(previous: float, following: float) -> float:
    """Return the whole turns that bring ``following`` nearest to ``previous`` [rad].

    Half a turn away, within 1e-9 rad, the numbers' own order decides the sense, so
    that rounding does not.
    """
    turn = shortest_turn(previous, following)
    if abs(turn) > _ALMOST_PI:
        turn = math.copysign(turn, following - previous)
    return previous + turn - following
