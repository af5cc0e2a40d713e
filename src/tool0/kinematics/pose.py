"""UR's poses as matrices: p[x, y, z, rx, ry, rz] has a rotation vector."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tool0.kinematics.chain import Array, cross_matrix, rodrigues

_SMALL = 1e-12


def matrix_of(pose: Sequence[float]) -> Array:
    """Return a pose as a homogeneous matrix, shape (4, 4)."""
    T = np.eye(4)
    T[:3, 3] = pose[:3]
    T[:3, :3] = rotation_of(pose[3:])
    return T


def rotation_of(vector: Sequence[float]) -> Array:
    """Return the rotation of a rotation vector [rad], shape (3, 3)."""
    v = np.asarray(vector, dtype=np.float64)
    angle = float(np.linalg.norm(v))
    if angle < _SMALL:
        return np.eye(3) + cross_matrix(*v)
    K = cross_matrix(*(v / angle))
    return rodrigues(K, K @ K, np.asarray(angle))
