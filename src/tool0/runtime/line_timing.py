"""When to be where on a way: fast, smooth, and slower where the joints need it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np

from tool0.errors import ControlError
from tool0.kinematics.chain import Array

if TYPE_CHECKING:
    import ruckig

SLOWEST = 1e-4
"""Smallest speed that is asked for on a way [of it per second]."""
_BISECTIONS = 40


class Stretch(NamedTuple):
    """A part of a way, from 0 to 1, and what is allowed on it."""

    end: float
    """Where it ends; it begins where the one before ends."""
    speed: float
    """[1/s]"""
    acceleration: float
    """[1/s²]"""
    jerk: float
    """[1/s³]"""


@final
class Timing:
    """Where on the way to be at each instant, from rest to rest.

    The speed is steady where one stretch meets the next: it changes within them.
    """

    def __init__(self, stretches: Sequence[Stretch]) -> None:
        import ruckig  # without annotations: its values are Any

        speeds = _border_speeds(stretches)
        self._parts: list[ruckig.Trajectory] = []
        self._starts: list[float] = []
        self.duration = 0.0
        """[s]"""
        begin = 0.0
        planner = ruckig.Ruckig(1)
        for stretch, before, after in zip(stretches, speeds, speeds[1:], strict=False):
            wanted = ruckig.InputParameter(1)
            wanted.current_position, wanted.target_position = [begin], [stretch.end]
            wanted.current_velocity, wanted.target_velocity = [before], [after]
            wanted.max_velocity = [max(stretch.speed, before, after)]
            wanted.max_acceleration = [stretch.acceleration]
            wanted.max_jerk = [stretch.jerk]
            part = ruckig.Trajectory(1)
            try:
                planner.calculate(wanted, part)
            except ruckig.RuckigError as error:
                raise ControlError(f"found no timing for {stretch}: {error}") from None
            self._parts.append(part)
            self._starts.append(self.duration)
            self.duration += part.duration
            begin = stretch.end

    def at(self, times: Array) -> Array:
        """Return place [0 … 1], speed [1/s] and acceleration [1/s²], shape (n, 3)."""
        parts = np.searchsorted(self._starts, times, side="right") - 1
        rows = [
            [values[0] for values in self._parts[k].at_time(time - self._starts[k])]
            for k, time in zip(parts.tolist(), times.tolist(), strict=True)
        ]
        return np.array(rows)


def _border_speeds(stretches: Sequence[Stretch]) -> list[float]:
    """Return the speed at each border: as much as can be reached from both sides."""
    inner = [min(a.speed, b.speed) for a, b in itertools.pairwise(stretches)]
    speeds = [0.0, *inner, 0.0]
    ends = [0.0, *(stretch.end for stretch in stretches)]
    order = range(len(stretches))
    for k in order:
        way = ends[k + 1] - ends[k]
        speeds[k + 1] = min(speeds[k + 1], _fastest_after(speeds[k], way, stretches[k]))
    for k in reversed(order):
        way = ends[k + 1] - ends[k]
        speeds[k] = min(speeds[k], _fastest_after(speeds[k + 1], way, stretches[k]))
    return speeds


def _fastest_after(speed: float, way: float, stretch: Stretch) -> float:
    """Return the largest steady speed that ``way`` allows to reach from ``speed``."""
    low, high = speed, max(stretch.speed, speed)
    if _way_between(speed, high, stretch) <= way:
        return high
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2.0
        if _way_between(speed, middle, stretch) <= way:
            low = middle
        else:
            high = middle
    return low


def _way_between(slow: float, fast: float, stretch: Stretch) -> float:
    """Return the way on which a speed becomes another, both steady."""
    change = fast - slow
    a, j = stretch.acceleration, stretch.jerk
    time = change / a + a / j if change >= a * a / j else 2.0 * (change / j) ** 0.5
    return (slow + fast) / 2.0 * time
