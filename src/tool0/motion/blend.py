"""Smooth transitions between two paths of a tool near a waypoint.

A pose near the waypoint is described by six numbers relative to the waypoint: the
displacement, and the rotation vector from the waypoint's orientation. A blend is a
cubic Hermite curve of the six numbers over time. The curve has the same pose and
velocity as each path at the transition points. Between two lines with equal speeds, the
blend is a parabola with constant acceleration.
"""

from __future__ import annotations

import math
from typing import NamedTuple, final

import numpy as np

from tool0.description.transform_arrays import (
    from_rotation_vectors,
    left_jacobians,
    rotation_vector,
)
from tool0.kinematics.chain import Array

TURN_RATIO = 4.0
"""Ratio of a tool's angular speed to its linear speed [rad/m]; see ``moves``."""
_METRIC = np.array([1.0, 1.0, 1.0, *[1.0 / TURN_RATIO] * 3])
_SHARPEST_ARC = -0.5
"""Cosine of the maximum angle by which an arc turns (120°)."""


class ToolState(NamedTuple):
    """Pose and velocity of a tool at a point of its path."""

    T: Array
    """Pose of the tool, shape (4, 4)."""
    V: Array
    """Twist of the tool, linear above angular [m/s, rad/s], shape (6,)."""


@final
class BlendPath:
    """Blend from one path to another; s is the fraction of the blend's time, 0 … 1."""

    noun = "blend"

    def __init__(
        self,
        start: ToolState,
        end: ToolState,
        T_base_waypoint: Array,
        *,
        is_arc: bool = False,
    ) -> None:
        """Create the blend; poses have shape (4, 4).

        Args:
            start: State of the tool where it leaves the first path.
            end: State of the tool where it enters the second path.
            T_base_waypoint: Pose of the tool at which the two paths meet.
            is_arc: Whether the tool follows a circular arc. For an arc, s is the
                fraction of the arc's length, and start and end must lie on straight
                lines at equal distances from the waypoint.
        """
        self._R, self._p = T_base_waypoint[:3, :3], T_base_waypoint[:3, 3]
        here, there = self._relative(start), self._relative(end)
        self._arc = _Arc(here[0][:3], here[1][:3], there[1][:3]) if is_arc else None
        if self._arc is not None:
            self.length = self._arc.length
            slow, fast = (np.linalg.norm(state.V[:3]) for state in (start, end))
            scales = self.length / np.array([slow, fast])
            self.duration = 2.0 * self.length / float(slow + fast)
        else:
            ways = np.linalg.norm([here[0] * _METRIC, there[0] * _METRIC], axis=1)
            speeds = np.linalg.norm([here[1] * _METRIC, there[1] * _METRIC], axis=1)
            self.duration = 2.0 * float(ways.sum() / speeds.sum())
            """Duration [s], at the mean of the two speeds."""
            scales = np.full(2, self.duration)
            self.length = float(
                np.linalg.norm([here[0][:3], there[0][:3]], axis=1).sum()
            )
            """Approximate length of the blend [m]."""
        self._controls = np.array(
            [here[0], here[1] * scales[0], there[0], there[1] * scales[1]]
        )
        turns = np.linalg.norm([here[0][3:], there[0][3:]], axis=1)
        self.angle = float(turns.sum())
        """Approximate angle by which the tool turns [rad]."""

    def tool(self, s: Array) -> Array:
        """Return the tool's pose at each s, shape (n, 4, 4)."""
        place = self._place(s)
        T = np.empty((len(s), 4, 4))
        T[:, :3, :3] = from_rotation_vectors(place[:, 3:]) @ self._R
        T[:, :3, 3] = self._p + place[:, :3]
        T[:, 3] = (0.0, 0.0, 0.0, 1.0)
        return T

    def twist(self, s: Array, T_base_tip: Array) -> Array:
        """Return the twist per unit of s of a frame fixed to the tool, shape (n, 6)."""
        place, slope = self._place(s), self._slope(s)
        angular = (left_jacobians(place[:, 3:]) @ slope[:, 3:, None])[..., 0]
        lever = T_base_tip[:, :3, 3] - self._p - place[:, :3]
        return np.concatenate(
            [slope[:, :3] + np.cross(angular, lever), angular], axis=1
        )

    def _relative(self, state: ToolState) -> tuple[Array, Array]:
        """Return the six numbers of a state and their time derivatives."""
        turn = rotation_vector(state.T[:3, :3] @ self._R.T)
        rate = np.linalg.solve(left_jacobians(turn[None])[0], state.V[3:])
        place = np.concatenate([state.T[:3, 3] - self._p, turn])
        return place, np.concatenate([state.V[:3], rate])

    def _place(self, s: Array) -> Array:
        t, square, cube = s, s * s, s * s * s
        basis = np.stack(
            [
                2 * cube - 3 * square + 1,
                cube - 2 * square + t,
                3 * square - 2 * cube,
                cube - square,
            ],
            axis=1,
        )
        place = np.asarray(basis @ self._controls)
        if self._arc is not None:
            place[:, :3] = self._arc.points(s)
        return place

    def _slope(self, s: Array) -> Array:
        square = s * s
        basis = np.stack(
            [
                6 * square - 6 * s,
                3 * square - 4 * s + 1,
                6 * s - 6 * square,
                3 * square - 2 * s,
            ],
            axis=1,
        )
        slope = np.asarray(basis @ self._controls)
        if self._arc is not None:
            slope[:, :3] = self._arc.slopes(s)
        return slope


@final
class _Arc:
    """The circular arc that is tangent to two lines that intersect at the origin."""

    def __init__(self, start: Array, entry: Array, exit: Array) -> None:
        """Use the start [m] and the directions of the two lines, each of shape (3,)."""
        self._u = entry / np.linalg.norm(entry)
        out = exit / np.linalg.norm(exit)
        across = out - self._u * (self._u @ out)
        sine, cosine = float(np.linalg.norm(across)), float(self._u @ out)
        self._turn = math.atan2(sine, cosine)
        self._v = across / sine if sine > 0.0 else np.zeros(3)
        self._start = start
        distance = float(np.linalg.norm(start))
        half = self._turn / 2.0
        self.length = distance * self._turn / math.tan(half) if half else 2 * distance

    def points(self, s: Array) -> Array:
        a = self._turn * s
        # sin(a)/a and (1 - cos(a))/a, which are 1 and 0 for a straight line
        along, aside = np.sinc(a / np.pi), np.sin(a / 2) * np.sinc(a / (2 * np.pi))
        way = (self.length * s)[:, None]
        return self._start + way * (along[:, None] * self._u + aside[:, None] * self._v)

    def slopes(self, s: Array) -> Array:
        a = (self._turn * s)[:, None]
        return np.asarray(self.length * (np.cos(a) * self._u + np.sin(a) * self._v))


def has_arc(entry: Array, exit: Array) -> bool:
    """Return whether an arc joins two lines with the given directions.

    At sharper corners, an arc needs much more acceleration than a parabola.
    """
    cosine = float(entry @ exit) / float(np.linalg.norm(entry) * np.linalg.norm(exit))
    return cosine > _SHARPEST_ARC
