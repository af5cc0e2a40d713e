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


def rotation_vector(R: Array) -> Array:
    """Return the rotation vector of a rotation, of length 0 … pi [rad].

    By the quaternion whose largest component is computed first (Shepperd 1978): exact
    also near 0 and pi.
    """
    (a, b, c), (d, e, f), (g, h, i) = R
    trace = a + e + i
    choices = (trace, a, e, i)
    k = int(np.argmax(choices))
    if k == 0:
        q = np.array([1.0 + trace, h - f, c - g, d - b])
    elif k == 1:
        q = np.array([h - f, 1.0 + a - e - i, b + d, c + g])
    elif k == 2:
        q = np.array([c - g, b + d, 1.0 - a + e - i, f + h])
    else:
        q = np.array([d - b, c + g, f + h, 1.0 - a - e + i])
    q /= np.linalg.norm(q)
    if q[0] < 0.0:
        q = -q
    sine = float(np.linalg.norm(q[1:]))
    if sine < _SMALL:
        return np.asarray(2.0 * q[1:])
    return np.asarray(q[1:] * (2.0 * np.arctan2(sine, q[0]) / sine))
