"""A straight line of poses."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from tool0.description.transform import from_matrix
from tool0.description.transform_arrays import cross_matrices, rotations_about
from tool0.kinematics.chain import Array


@final
class LinePath:
    """Poses of a tool along a straight line, with a steady rotation about one axis.

    Poses are in the frame of the arm's base link. The path parameter s is 0 … 1.
    """

    noun = "line"

    def __init__(self, start: Array, end: Array) -> None:
        """Use the poses of the tool at both ends, shape (4, 4)."""
        self._start = start
        displacement = end[:3, 3] - start[:3, 3]
        turn = np.eye(4)
        turn[:3, :3] = end[:3, :3] @ start[:3, :3].T
        w, *xyz = from_matrix(turn).quat_wxyz
        self.length = float(np.linalg.norm(displacement))
        """Length of the line [m]."""
        sine = float(np.linalg.norm(xyz))
        self.angle = 2.0 * math.atan2(sine, w)
        """Angle by which the tool turns [rad]."""
        axis = np.array(xyz) / sine if sine > 0.0 else np.zeros(3)
        self._displacement = displacement
        self._turn = axis * self.angle

    def tool(self, s: Array) -> Array:
        """Return the tool's pose at each s, shape (n, 4, 4)."""
        T = np.empty((len(s), 4, 4))
        T[:, :3, :3] = _rotations(self._turn, s) @ self._start[:3, :3]
        T[:, :3, 3] = self._start[:3, 3] + s[:, None] * self._displacement
        T[:, 3] = (0.0, 0.0, 0.0, 1.0)
        return T

    def twist(self, s: Array, T_base_tip: Array) -> Array:
        """Return the twist per unit of s of a frame fixed to the tool, shape (n, 6)."""
        lever = T_base_tip[:, :3, 3] - self.tool(s)[:, :3, 3]
        linear = self._displacement + np.cross(self._turn, lever)
        angular = np.broadcast_to(self._turn, linear.shape)
        return np.concatenate([linear, angular], axis=1)


def _rotations(rotation_vector: Array, s: Array) -> Array:
    """Return the rotations by ``s`` times a rotation vector, shape (n, 3, 3)."""
    angle = float(np.linalg.norm(rotation_vector))
    if angle == 0.0:
        return np.broadcast_to(np.eye(3), (len(s), 3, 3))
    K = cross_matrices(rotation_vector / angle)
    return rotations_about(K, K @ K, angle * s)
