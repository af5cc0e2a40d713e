"""UR's poses: a position and a rotation vector, p[x, y, z, rx, ry, rz]."""

from __future__ import annotations

import numpy as np

from tool0.kinematics.chain import Array
from tool0.kinematics.pose import matrix_of, rotation_of
from tool0.requests.updates import Six

__all__ = ["matrix_of", "pose_of", "rotation_of", "rotation_vector"]
_SMALL = 1e-12


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


def pose_of(T: Array) -> Six:
    """Return a homogeneous matrix as a pose."""
    x, y, z = T[:3, 3].tolist()
    rx, ry, rz = rotation_vector(T[:3, :3]).tolist()
    return (x, y, z, rx, ry, rz)
