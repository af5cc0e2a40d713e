"""Rigid transforms with plain floats: URDF poses, quaternions and rotation vectors.

``transform_arrays`` contains the corresponding functions for arrays of transforms.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from tool0.description.units import require_plausible_angles
from tool0.errors import ModelError

if TYPE_CHECKING:  # NumPy is slow to import
    import numpy as np
    from numpy.typing import NDArray

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""Quaternion in the order w, x, y, z."""
Rotation = tuple[Vector3, Vector3, Vector3]
"""Rows of a rotation matrix."""

FARTHEST = 1e6
"""Largest coordinate of a requested pose [m]."""
_SMALL = 1e-12
"""Angle below which the relation between a rotation and its rotation vector is
linearized [rad]."""
_IDENTITY: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """Pose of a frame in the parent frame, in the form of URDF's ``<origin>``."""

    xyz: Vector3 = (0.0, 0.0, 0.0)
    """Position of the frame's origin [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw about fixed axes [rad]: R = Rz(yaw) Ry(pitch) Rx(roll)."""

    def __post_init__(self) -> None:
        """Raise ConfigError if an angle is so large that it must be in degrees."""
        require_plausible_angles(self.rpy, "rpy")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Transform:
    """The pose of one frame in another: ``T_a_c = T_a_b @ T_b_c``."""

    position: Vector3 = (0.0, 0.0, 0.0)
    """Position of the frame's origin [m]."""
    rotation: Rotation = _IDENTITY
    """Rows of the rotation matrix, shape (3, 3)."""

    def __matmul__(self, other: Transform) -> Transform:
        """Return the pose of ``other``, given in this frame, in the parent frame."""
        (a, b, c), (d, e, f), (g, h, i) = self.rotation
        (A, B, C), (D, E, F), (G, H, I) = other.rotation  # noqa: E741
        return Transform(
            position=self.apply(other.position),
            rotation=(  # each sum starts at 0.0, so that no zero is negative
                (
                    0.0 + a * A + b * D + c * G,
                    0.0 + a * B + b * E + c * H,
                    0.0 + a * C + b * F + c * I,
                ),
                (
                    0.0 + d * A + e * D + f * G,
                    0.0 + d * B + e * E + f * H,
                    0.0 + d * C + e * F + f * I,
                ),
                (
                    0.0 + g * A + h * D + i * G,
                    0.0 + g * B + h * E + i * H,
                    0.0 + g * C + h * F + i * I,
                ),
            ),
        )

    def apply(self, point: Vector3) -> Vector3:
        """Return ``point``, given in this frame, in the parent frame."""
        x, y, z = point
        px, py, pz = self.position
        a, b, c = self.rotation
        return (
            px + a[0] * x + a[1] * y + a[2] * z,
            py + b[0] * x + b[1] * y + b[2] * z,
            pz + c[0] * x + c[1] * y + c[2] * z,
        )

    def rotate(self, vector: Vector3) -> Vector3:
        """Return a free ``vector``, given in this frame, in the parent's axes."""
        return Transform(rotation=self.rotation).apply(vector)

    def inverse(self) -> Transform:
        """Return the inverse of this transform."""
        a, b, c = zip(*self.rotation, strict=True)
        transposed = Transform(rotation=(a, b, c))
        x, y, z = transposed.apply(self.position)
        return Transform(position=(-x, -y, -z), rotation=transposed.rotation)

    @property
    def quat_wxyz(self) -> Quaternion:
        """The rotation as a unit quaternion with w >= 0."""
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = self.rotation
        # Use the root of the largest component, so that no division by nearly 0 occurs.
        squares = (
            1 + xx + yy + zz,
            1 + xx - yy - zz,
            1 - xx + yy - zz,
            1 - xx - yy + zz,
        )
        largest = squares.index(max(squares))
        root = 2 * math.sqrt(squares[largest])
        if largest == 0:
            w, x, y, z = root / 4, (zy - yz) / root, (xz - zx) / root, (yx - xy) / root
        elif largest == 1:
            w, x, y, z = (zy - yz) / root, root / 4, (xy + yx) / root, (xz + zx) / root
        elif largest == 2:
            w, x, y, z = (xz - zx) / root, (xy + yx) / root, root / 4, (yz + zy) / root
        else:
            w, x, y, z = (yx - xy) / root, (xz + zx) / root, (yz + zy) / root, root / 4
        return (w, x, y, z) if w >= 0 else (-w, -x, -y, -z)

    @property
    def rotation_vector(self) -> Vector3:
        """The rotation as the product of axis and angle [rad], with length 0 … π."""
        w, x, y, z = self.quat_wxyz
        sine = math.hypot(x, y, z)
        factor = 2.0 / w if sine < _SMALL else 2.0 * math.atan2(sine, w) / sine
        return factor * x, factor * y, factor * z

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The homogeneous matrix, shape (4, 4)."""
        import numpy as np

        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self.position
        return matrix

    def __repr__(self) -> str:
        """Return position and quaternion as text, rounded to 6 decimal places."""
        position = ", ".join(_short(value) for value in self.position)
        quat = ", ".join(_short(value) for value in self.quat_wxyz)
        return f"Transform(position=({position}), quat_wxyz=({quat}))"


def to_transform(pose: Pose) -> Transform:
    """Return ``pose``, given in the form of URDF's ``<origin>``, as a transform."""
    roll, pitch, yaw = pose.rpy
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return Transform(
        position=pose.xyz,
        rotation=(
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        ),
    )


def pose_matrix(pose: Pose) -> NDArray[np.float64]:
    """Return ``pose`` as a homogeneous matrix, shape (4, 4)."""
    return to_transform(pose).matrix


def to_pose(transform: Transform) -> Pose:
    """Return ``transform`` in the form of URDF's ``<origin>``."""
    (xx, _, _), (yx, yy, yz), (zx, zy, zz) = transform.rotation
    horizontal = math.hypot(xx, yx)
    if horizontal > 1e-9:  # for larger values, roll and yaw are distinct
        rpy = (math.atan2(zy, zz), math.atan2(-zx, horizontal), math.atan2(yx, xx))
    else:
        rpy = (math.atan2(-yz, yy), math.atan2(-zx, horizontal), 0.0)
    return Pose(xyz=transform.position, rpy=rpy)


def from_quaternion(position: Sequence[float], quat_wxyz: Sequence[float]) -> Transform:
    """Return the transform with a position and a quaternion of any positive norm."""
    px, py, pz = position
    length = math.hypot(*quat_wxyz)
    w, x, y, z = (part / length for part in quat_wxyz)
    return Transform(
        position=(px, py, pz),
        rotation=(
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        ),
    )


def from_rotation_vector(
    position: Sequence[float], rotation_vector: Sequence[float]
) -> Transform:
    """Return the transform with a position and a rotation vector [rad]."""
    px, py, pz = position
    x, y, z = rotation_vector
    angle = math.hypot(x, y, z)
    if angle < _SMALL:
        rotation: Rotation = ((1.0, -z, y), (z, 1.0, -x), (-y, x, 1.0))
    else:
        rotation = rotation_about((x / angle, y / angle, z / angle), angle)
    return Transform(position=(px, py, pz), rotation=rotation)


def rotation_about(axis: Vector3, angle: float) -> Rotation:
    """Return the rotation by ``angle`` [rad] about a unit vector."""
    x, y, z = axis
    c, s = math.cos(angle), math.sin(angle)
    v = 1.0 - c
    return (
        (c + x * x * v, x * y * v - z * s, x * z * v + y * s),
        (y * x * v + z * s, c + y * y * v, y * z * v - x * s),
        (z * x * v - y * s, z * y * v + x * s, c + z * z * v),
    )


def from_matrix(T: NDArray[np.float64]) -> Transform:
    """Return a homogeneous matrix, shape (4, 4), as a transform."""
    return from_arrays(T[:3, 3], T[:3, :3])


def from_arrays(
    position: NDArray[np.float64], rotation: NDArray[np.float64]
) -> Transform:
    """Return the transform with a position, (3,), and a rotation matrix, (3, 3)."""
    x, y, z = position.tolist()
    a, b, c = map(tuple, rotation.tolist())
    return Transform(position=(x, y, z), rotation=(a, b, c))


AnyPose = Transform | Pose | Iterable[Sequence[float]]
"""A pose in one of the accepted forms.  A sequence is a homogeneous matrix, shape (4,
4)."""


def as_matrix(pose: AnyPose) -> NDArray[np.float64]:
    """Return a pose as a homogeneous matrix, shape (4, 4).

    A rotation that is not exactly orthogonal is replaced by the nearest orthogonal
    matrix.

    Raises:
        ModelError: If the value is not a pose.
    """
    import numpy as np

    given: object = pose
    try:
        if isinstance(given, Pose):
            given = to_transform(given)
        if isinstance(given, Transform):
            given = given.matrix
        T = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise ModelError(
            f"a pose must be a Transform, a Pose or a (4, 4) array, got {pose!r:.80}"
        ) from None
    if T.shape != (4, 4) or not np.isfinite(T).all():
        raise ModelError(
            f"a pose must be finite and of shape (4, 4), got {T.shape}: {T.tolist()}"
        )
    if np.abs(T).max() > FARTHEST:
        raise ModelError(
            f"a pose must be within {FARTHEST:g} m, got {T.flat[np.abs(T).argmax()]:g}"
        )
    R = T[:3, :3]
    is_rotation = np.abs(R @ R.T - np.eye(3)).max() < 1e-3 and np.linalg.det(R) > 0
    if not is_rotation or np.abs(T[3] - [0, 0, 0, 1]).max() > 1e-9:
        raise ModelError(
            "the array is not a pose: need a rotation at top left and 0 0 0 1 below, "
            f"got {T.tolist()}"
        )
    U, _, Vt = np.linalg.svd(R)
    T[:3, :3] = U @ Vt
    return T


def add(a: Vector3, b: Vector3) -> Vector3:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Vector3, b: Vector3) -> Vector3:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def cross(a: Vector3, b: Vector3) -> Vector3:
    """Return the cross product of a and b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def rotate_by(quat_wxyz: Quaternion, vector: Vector3) -> Vector3:
    """Return ``vector`` rotated by a unit quaternion."""
    w, x, y, z = quat_wxyz
    a, b, c = vector
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        a + w * p + y * r - z * q,
        b + w * q + z * p - x * r,
        c + w * r + x * q - y * p,
    )


def _short(value: float) -> str:
    return f"{round(value, 6) + 0.0:g}"
