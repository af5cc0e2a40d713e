"""Many rotation vectors at once: rotations, and the derivatives of rotations."""

from __future__ import annotations

import numpy as np

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
