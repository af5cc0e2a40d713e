"""A circular arc of poses."""

from __future__ import annotations

from typing import final

import numpy as np

from tool0.description.transform_arrays import from_rotation_vectors, rotation_vector
from tool0.errors import UnreachableError
from tool0.kinematics.chain import Array

_STRAIGHT = 1e-4
"""Sine of the angle at the start below which three points are considered collinear."""


@final
class CirclePath:
    """Poses of a tool along an arc from a pose through a point to another pose.

    Poses are in the frame of the arm's base link. The path parameter s is 0 … 1.
    """

    noun = "arc"

    def __init__(
        self,
        start: Array,
        via: Array,
        end: Array,
        *,
        mode: int = 0,
    ) -> None:
        """Create the path; poses have shape (4, 4), and ``via`` has shape (3,).

        Args:
            start: Pose of the tool at the start.
            via: A point of the arc between the start and the end.
            end: Pose of the tool at the end; in mode 1, only its position is used.
            mode: In mode 0, the orientation is interpolated by a rotation about one
                axis. In mode 1, the tool keeps its angle to the tangent of the arc.

        Raises:
            UnreachableError: If the three points lie on a line.
        """
        self._start = start
        first, second = via - start[:3, 3], end[:3, 3] - start[:3, 3]
        normal = np.cross(first, second)
        size = float(np.linalg.norm(normal))
        if not size > _STRAIGHT * np.linalg.norm(first) * np.linalg.norm(second):
            raise UnreachableError(
                "start, via and end of an arc are on a line, or two of them are one "
                "point; use a line, or two arcs for a full circle"
            )
        normal = normal / size
        # The center relative to the start, at equal distances from all three points.
        across = first @ first * second - second @ second * first
        centre = np.cross(across, normal) / (2.0 * size)
        self.radius = float(np.linalg.norm(centre))
        """Radius of the arc [m]."""
        self._centre = start[:3, 3] + centre
        self._u = -centre / self.radius
        self._v = np.cross(normal, self._u)
        beyond = end[:3, 3] - self._centre
        self._sweep = float(np.arctan2(beyond @ self._v, beyond @ self._u)) % (
            2 * np.pi
        )
        if mode == 0:
            self._turn = rotation_vector(end[:3, :3] @ start[:3, :3].T)
        else:
            self._turn = normal * self._sweep
        self.length = self.radius * self._sweep
        """Length of the arc [m]."""
        self.angle = float(np.linalg.norm(self._turn))
        """Angle by which the tool turns [rad]."""

    def tool(self, s: Array) -> Array:
        """Return the tool's pose at each s, shape (n, 4, 4)."""
        cos, sin = np.cos(self._sweep * s), np.sin(self._sweep * s)
        T = np.empty((len(s), 4, 4))
        T[:, :3, :3] = (
            from_rotation_vectors(s[:, None] * self._turn) @ self._start[:3, :3]
        )
        outward = cos[:, None] * self._u + sin[:, None] * self._v
        T[:, :3, 3] = self._centre + self.radius * outward
        T[:, 3] = (0.0, 0.0, 0.0, 1.0)
        return T

    def twist(self, s: Array, T_base_tip: Array) -> Array:
        """Return the twist per unit of s of a frame fixed to the tool, shape (n, 6)."""
        cos, sin = np.cos(self._sweep * s), np.sin(self._sweep * s)
        along = cos[:, None] * self._v - sin[:, None] * self._u
        lever = T_base_tip[:, :3, 3] - self.tool(s)[:, :3, 3]
        linear = self.length * along + np.cross(self._turn, lever)
        angular = np.broadcast_to(self._turn, linear.shape)
        return np.concatenate([linear, angular], axis=1)
