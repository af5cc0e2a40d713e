"""Functions for arrays of rotations and rigid transforms.

``transform`` contains the functions for single transforms.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tool0.description.transform import Transform, from_arrays, from_rotation_vector

Array = NDArray[np.float64]

_SMALL = 1e-4
"""Angle below which the quotients are computed from power series [rad].  At this angle,
the first neglected terms are about 1e-16."""


class Frames(NamedTuple):
    """n rigid transforms."""

    position: Array
    """Positions of the frames' origins [m], shape (n, 3)."""
    rotation: Array
    """Rotation matrices, shape (n, 3, 3)."""

    @classmethod
    def of(cls, T: Transform) -> Frames:
        """Return a transform as an array with n = 1, which composes with any array."""
        return cls(np.array([T.position]), np.array([T.rotation]))

    def __matmul__(self, other: Frames | Transform) -> Frames:
        """Return the poses ``other``, given in these frames, in the parent frames."""
        position, rotation = np.asarray(other.position), np.asarray(other.rotation)
        return Frames(
            self.position + (self.rotation @ position[..., None])[..., 0],
            self.rotation @ rotation,
        )

    def inverse(self) -> Frames:
        """Return the inverses of these transforms."""
        transposed = self.rotation.swapaxes(-1, -2)
        return Frames(-(transposed @ self.position[..., None])[..., 0], transposed)

    @property
    def quat_wxyz(self) -> Array:
        """The rotations as unit quaternions with w >= 0, shape (n, 4)."""
        return quats_wxyz(self.rotation)

    @property
    def matrices(self) -> Array:
        """The transforms as matrices, shape (n, 4, 4)."""
        T = np.zeros((len(self.position), 4, 4))
        T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = self.rotation, self.position, 1.0
        return T

    @property
    def yaw(self) -> Array:
        """Angles of the frames' x axes about the parent's z axis [rad], shape (n,)."""
        return yaw_of(self.rotation)


def cross_matrices(vectors: Array) -> Array:
    """Return matrices K, (…, 3, 3), with K @ u = v x u for vectors v, (…, 3)."""
    K = np.zeros((*vectors.shape, 3))
    K[..., 2, 1], K[..., 0, 2], K[..., 1, 0] = np.moveaxis(vectors, -1, 0)
    K[..., 1, 2], K[..., 2, 0], K[..., 0, 1] = np.moveaxis(-vectors, -1, 0)
    return K


def rotations_about(K: Array, K_squared: Array, angle: Array) -> Array:
    """Return rotations by ``angle`` [rad], shape (…), about unit axes.

    The function implements Rodrigues' formula.  ``K`` contains the cross-product
    matrices of the axes.  The shape of ``K`` is (3, 3) or that of the result, (…, 3,
    3).
    """
    sin, versine = np.sin(angle), 1.0 - np.cos(angle)
    turn = sin[..., None, None] * K
    return np.asarray(np.eye(3) + turn + versine[..., None, None] * K_squared)


def from_rotation_vectors(vectors: Array) -> Array:
    """Return rotation vectors [rad], (n, 3), as rotation matrices, (n, 3, 3)."""
    K = cross_matrices(vectors)
    first, second, _ = _quotients(vectors)
    return np.asarray(
        np.eye(3) + first[:, None, None] * K + second[:, None, None] * (K @ K)
    )


def left_jacobians(vectors: Array) -> Array:
    """Return J, (n, 3, 3), with ω = J v̇ for R = exp(v) and ω in the fixed axes.

    J = 1 + (1 - cos θ)/θ² K + (θ - sin θ)/θ³ K², where K is the cross-product matrix of
    v.  See T.  D.  Barfoot, State Estimation for Robotics (2017), equation (7.77).
    """
    K = cross_matrices(vectors)
    _, second, third = _quotients(vectors)
    return np.asarray(
        np.eye(3) + second[:, None, None] * K + third[:, None, None] * (K @ K)
    )


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


def sine_vectors(R: Array) -> Array:
    """Return the product of axis and 2 sin(angle) of each rotation, shape (n, 3)."""
    return np.stack(
        [R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]],
        axis=1,
    )


def quats_wxyz(R: Array) -> Array:
    """Return rotations, (n, 3, 3), as unit quaternions with w >= 0, shape (n, 4)."""
    xx, yy, zz = R[:, 0, 0], R[:, 1, 1], R[:, 2, 2]
    # Products of the quaternion's components.  The row of the largest component has the
    # best numerical accuracy.
    table = np.empty((len(R), 4, 4))
    table[:, 0, 0] = 1 + xx + yy + zz
    table[:, 1, 1] = 1 + xx - yy - zz
    table[:, 2, 2] = 1 - xx + yy - zz
    table[:, 3, 3] = 1 - xx - yy + zz
    for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
        a, b = j - 1, k - 1
        table[:, 0, i] = table[:, i, 0] = R[:, b, a] - R[:, a, b]
        table[:, j, k] = table[:, k, j] = R[:, b, a] + R[:, a, b]
    largest = table[:, range(4), range(4)].argmax(axis=1)
    quat = table[np.arange(len(R)), largest]
    quat /= np.linalg.norm(quat, axis=1, keepdims=True)
    return np.asarray(np.where(quat[:, :1] < 0.0, -quat, quat))


def from_quats(quat_wxyz: Array) -> Array:
    """Return quaternions of any norm, (n, 4), as rotation matrices, (n, 3, 3)."""
    w, x, y, z = (quat_wxyz / np.linalg.norm(quat_wxyz, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def yaws_of_quats(quat_wxyz: Array) -> Array:
    """Return ``yaw_of``, shape (n,), of rotations given as unit quaternions, (n, 4)."""
    w, x, y, z = quat_wxyz.T
    return np.asarray(np.arctan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z)))


def rotated_by(quat_wxyz: Array, vectors: Array) -> Array:
    """Return ``vectors``, (…, 3), rotated by unit quaternions, (…, 4).

    The result is bit-identical to that of ``transform.rotate_by``.
    """
    w, x, y, z = np.moveaxis(quat_wxyz, -1, 0)
    a, b, c = np.moveaxis(vectors, -1, 0)
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return np.stack(
        [
            a + w * p + y * r - z * q,
            b + w * q + z * p - x * r,
            c + w * r + x * q - y * p,
        ],
        axis=-1,
    )


def to_rpy(R: Array) -> Array:
    """Return roll, pitch and yaw about fixed axes [rad], shape (n, 3)."""
    pitch = np.arctan2(-R[:, 2, 0], np.hypot(R[:, 2, 1], R[:, 2, 2]))
    roll = np.arctan2(R[:, 2, 1], R[:, 2, 2])
    return np.stack([roll, pitch, yaw_of(R)], axis=1)


def yaw_of(R: Array) -> Array:
    """Return the angles of the x axes about the fixed z axis [rad], shape (n,)."""
    return np.asarray(np.arctan2(R[:, 1, 0], R[:, 0, 0]))


def turn_z_to(axis: Sequence[float]) -> Array:
    """Return a rotation, shape (3, 3), with the unit ``axis`` as third column."""
    z = np.asarray(axis, dtype=float)
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def matrix_of(pose: Sequence[float]) -> Array:
    """Return x, y, z and a rotation vector [m, rad] as a matrix, shape (4, 4)."""
    return from_rotation_vector(pose[:3], pose[3:]).matrix


def rotation_vector(R: Array) -> Array:
    """Return the rotation vector [rad], of length 0 … π, of a matrix, (3, 3)."""
    return np.array(from_arrays(np.zeros(3), R).rotation_vector)
