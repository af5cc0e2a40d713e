"""A straight line of poses."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from tool0.kinematics.chain import Array
from tool0.kinematics.pose_matrix import as_transform


@final
class Line:
    """Poses of a tool from one to another: straight, turning about one axis steadily.

    Poses are in the link that carries the arm; a place on the line is from 0 to 1.
    """

    def __init__(
        self,
        start: Array,
        end: Array,
        T_tip_tool: Array,
        T_root_base: Array | None = None,
    ) -> None:
        """Make the line.

        Args:
            start: Pose of the tool at the start, shape (4, 4).
            end: Pose of the tool at the end, shape (4, 4).
            T_tip_tool: Pose of the tool in the arm's flange, shape (4, 4).
            T_root_base: Where the arm is, shape (4, 4), for what is said of the line.
        """
        self._T_root_base = np.eye(4) if T_root_base is None else T_root_base
        self._start = start
        self._T_tool_tip = np.linalg.inv(T_tip_tool)
        way = end[:3, 3] - start[:3, 3]
        turn = np.eye(4)
        turn[:3, :3] = end[:3, :3] @ start[:3, :3].T
        w, *xyz = as_transform(turn).quat_wxyz
        self.length = float(np.linalg.norm(way))
        """[m]"""
        sine = float(np.linalg.norm(xyz))
        self.angle = 2.0 * math.atan2(sine, w)
        """[rad]"""
        axis = np.array(xyz) / sine if sine > 0.0 else np.zeros(3)
        self._way, self._turn = way, axis * self.angle

    def tool(self, s: Array) -> Array:
        """Return the tool's pose at each place, shape (n, 4, 4)."""
        T = np.empty((len(s), 4, 4))
        T[:, :3, :3] = _turned(self._turn, s) @ self._start[:3, :3]
        T[:, :3, 3] = self._start[:3, 3] + s[:, None] * self._way
        T[:, 3] = (0.0, 0.0, 0.0, 1.0)
        return T

    def tip(self, s: Array) -> Array:
        """Return the flange's pose at each place, shape (n, 4, 4)."""
        tip: Array = self.tool(s) @ self._T_tool_tip
        return tip

    def twist(self, s: Array, T_base_tip: Array) -> Array:
        """Return how the flange moves per place, linear above angular, shape (n, 6)."""
        lever = T_base_tip[:, :3, 3] - self.tool(s)[:, :3, 3]
        linear = self._way + np.cross(self._turn, lever)
        angular = np.broadcast_to(self._turn, linear.shape)
        return np.concatenate([linear, angular], axis=1)

    def at(self, s: float) -> str:
        """Return where a place is, in words."""
        pose = as_transform(self._T_root_base @ self.tool(np.array([s]))[0])
        return f"at {s:.0%} of the line, where the tool is at {pose}"


def _turned(turn: Array, s: Array) -> Array:
    """Return the rotations by ``s`` times the rotation vector, shape (n, 3, 3)."""
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return np.broadcast_to(np.eye(3), (len(s), 3, 3))
    x, y, z = (turn / angle).tolist()
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    a = angle * s[:, None, None]
    turned: Array = np.eye(3) + np.sin(a) * K + (1.0 - np.cos(a)) * (K @ K)  # Rodrigues
    return turned
