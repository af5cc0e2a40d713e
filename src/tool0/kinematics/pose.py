"""UR's poses as matrices: p[x, y, z, rx, ry, rz] has a rotation vector."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tool0.kinematics.chain import Array, cross_matrix, rodrigues

Three = tuple[float, float, float]
Nine = tuple[float, float, float, float, float, float, float, float, float]
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
    """Return the rotation vector of a rotation, of length 0 … pi [rad]."""
    a, b, c, d, e, f, g, h, i = R.ravel().tolist()
    return np.array(rotation_vector_of((a, b, c, d, e, f, g, h, i)))


def rotation_vector_of(R: Nine) -> Three:
    """Return the rotation vector of a rotation that is given row by row [rad].

    By the quaternion whose largest component is computed first (Shepperd 1978): exact
    also near 0 and pi.
    """
    a, b, c, d, e, f, g, h, i = R
    trace = a + e + i
    largest = max(trace, a, e, i)
    if largest == trace:
        w, x, y, z = 1.0 + trace, h - f, c - g, d - b
    elif largest == a:
        w, x, y, z = h - f, 1.0 + a - e - i, b + d, c + g
    elif largest == e:
        w, x, y, z = c - g, b + d, 1.0 - a + e - i, f + h
    else:
        w, x, y, z = d - b, c + g, f + h, 1.0 - a - e + i
    sine = math.sqrt(x * x + y * y + z * z)
    if sine < _SMALL * abs(w):
        factor = 2.0 / w
    else:
        factor = math.copysign(2.0 / sine, w) * math.atan2(sine, abs(w))
    return (factor * x, factor * y, factor * z)
