"""Ways round a circle."""

from __future__ import annotations

import math

_ALMOST_PI = math.pi - 1e-9


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
