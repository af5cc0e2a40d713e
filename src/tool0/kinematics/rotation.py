"""Rotation vectors: axis times angle [rad], as in UR's poses p[x, y, z, rx, ry, rz]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tool0.description.transform import from_matrix
from tool0.kinematics.chain import Array

_SMALL = 1e-4
"""Below this angle series replace the quotients [rad]: the next terms are 1e-16."""


def rotations(vectors: Array) -> Array:
    """Return the rotations of rotation vectors, shape (n, 3), as (n, 3, 3)."""
    K = _crosses(vectors)
    first, second, _ = _quotients(vectors)
    return np.asarray(
        np.eye(3) + first[:, None, None] * K + second[:, None, None] * (K @ K)
    )


def rotation_vector(R: Array) -> Array:
    """Return the rotation vector of a rotation, of length 0 … π [rad], shape (3,).

    By the quaternion whose largest component is computed first: exact near 0 and π.
    """
    T = np.eye(4)
    T[:3, :3] = R
    w, *xyz = from_matrix(T).quat_wxyz
    sine = float(np.linalg.norm(xyz))
    if sine < 1e-12:
        return np.asarray(2.0 * np.array(xyz))
    return np.asarray(np.array(xyz) * (2.0 * np.arctan2(sine, w) / sine))


def left_jacobians(vectors: Array) -> Array:
    """Return J with ω = J v̇ for R = exp(v), ω in the fixed axes, shape (n, 3, 3).

    J = 1 + (1 - cos θ)/θ² K + (θ - sin θ)/θ³ K², with K the cross-product matrix of v:
    T. D. Barfoot, State Estimation for Robotics (2017), (7.77).
    """
    K = _crosses(vectors)
    _, second, third = _quotients(vectors)
    return np.asarray(
        np.eye(3) + second[:, None, None] * K + third[:, None, None] * (K @ K)
    )


def pose_matrix(pose: Sequence[float]) -> Array:
    """Return a pose p[x, y, z, rx, ry, rz] as a homogeneous matrix, shape (4, 4)."""
    T = np.eye(4)
    T[:3, 3] = pose[:3]
    T[:3, :3] = rotations(np.array([pose[3:]], dtype=np.float64))[0]
    return T


def _crosses(vectors: Array) -> Array:
    x, y, z = vectors.T
    K = np.zeros((len(vectors), 3, 3))
    K[:, 2, 1], K[:, 0, 2], K[:, 1, 0] = x, y, z
    K[:, 1, 2], K[:, 2, 0], K[:, 0, 1] = -x, -y, -z
    return K


def _quotients(vectors: Array) -> tuple[Array, Array, Array]:
    """Return sin θ/θ, (1 - cos θ)/θ² and (θ - sin θ)/θ³."""
    angle = np.linalg.norm(vectors, axis=1)
    small = angle < _SMALL
    t = np.where(small, 1.0, angle)
    square = angle * angle
    return (
        np.where(small, 1.0 - square / 6.0, np.sin(t) / t),
        np.where(small, 0.5 - square / 24.0, 2.0 * (np.sin(t / 2.0) / t) ** 2),
        np.where(small, 1.0 / 6.0 - square / 120.0, (t - np.sin(t)) / t**3),
    )
