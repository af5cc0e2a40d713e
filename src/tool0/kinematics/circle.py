"""A circular arc of poses."""

from __future__ import annotations

from typing import final

import numpy as np

from tool0.description.transform import from_matrix
from tool0.errors import UnreachableError
from tool0.kinematics.chain import Array
from tool0.kinematics.pose import rotation_vector
from tool0.kinematics.rotation import rotations

_STRAIGHT = 1e-4
"""Sine of the angle at the start, below which three points are on a line."""


@final
class CirclePath:
    """Poses of a tool along the arc from a pose through a point to another pose.

    Poses are in the link that carries the arm; the path parameter s goes from 0 to 1.
    """

    noun = "arc"

    def __init__(
        self,
        start: Array,
        via: Array,
        end: Array,
        T_tip_tool: Array,
        *,
        mode: int = 0,
        T_root_base: Array | None = None,
    ) -> None:
        """Make the path; poses have shape (4, 4), ``via`` has shape (3,).

        Args:
            start: Pose of the tool at the start.
            via: A point of the arc between start and end.
            end: Pose of the tool at the end; in mode 1 only its position is used.
            T_tip_tool: Pose of the tool in the arm's flange.
            mode: 0: the orientation is interpolated, turning about one axis; 1: it
                keeps its angle to the arc's tangent, as at the start.
            T_root_base: Pose of the arm's base, for messages.

        Raises:
            UnreachableError: If the three points are on a line.
        """
        self._T_root_base = np.eye(4) if T_root_base is None else T_root_base
        self._T_tool_tip = np.linalg.inv(T_tip_tool)
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
        # The centre from the start: equally far from all three points.
        across = first @ first * second - second @ second * first
        centre = np.cross(across, normal) / (2.0 * size)
        self.radius = float(np.linalg.norm(centre))
        """[m]"""
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
        """[m]"""
        self.angle = float(np.linalg.norm(self._turn))
        """[rad]"""

    def tool(self, s: Array) -> Array:
        """Return the tool's pose at each s, shape (n, 4, 4)."""
        cos, sin = np.cos(self._sweep * s), np.sin(self._sweep * s)
        T = np.empty((len(s), 4, 4))
        T[:, :3, :3] = rotations(s[:, None] * self._turn) @ self._start[:3, :3]
        outward = cos[:, None] * self._u + sin[:, None] * self._v
        T[:, :3, 3] = self._centre + self.radius * outward
        T[:, 3] = (0.0, 0.0, 0.0, 1.0)
        return T

    def tip(self, s: Array) -> Array:
        """Return the flange's pose at each s, shape (n, 4, 4)."""
        return np.asarray(self.tool(s) @ self._T_tool_tip)

    def twist(self, s: Array, T_base_tip: Array) -> Array:
        """Return the motion per s of a frame fixed to the tool, shape (n, 6)."""
        cos, sin = np.cos(self._sweep * s), np.sin(self._sweep * s)
        along = cos[:, None] * self._v - sin[:, None] * self._u
        lever = T_base_tip[:, :3, 3] - self.tool(s)[:, :3, 3]
        linear = self.length * along + np.cross(self._turn, lever)
        angular = np.broadcast_to(self._turn, linear.shape)
        return np.concatenate([linear, angular], axis=1)

    def at(self, s: float) -> str:
        """Return the place of s on the path, as text."""
        pose = from_matrix(self._T_root_base @ self.tool(np.array([s]))[0])
        return f"at {s:.0%} of the arc, where the tool is at {pose}"
