"""Definitions that the node shares with tool0.

Copied by tools/ros2_copies.py from tool0's modules; do not edit.
"""

from __future__ import annotations

import enum
import math
import os
import re
import socket
import stat
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar, final

from tool0_ros2.errors import TransportError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from tool0_ros2.kinematics import Joint


def folders() -> tuple[Path, ...]:
    """Return the folders that may contain sockets, with the preferred folder first.

    ``XDG_RUNTIME_DIR`` is private to the user and is emptied at logout.  If this
    variable is not set (for example, in a container or under cron), a folder with mode
    0700 is used instead.
    """
    import tempfile

    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    fallback = Path(tempfile.gettempdir()) / f"tool0-{os.getuid()}"
    if runtime and Path(runtime).is_absolute():
        return (Path(runtime) / "tool0", fallback)
    return (fallback,)


_MAX_PATH = 103
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


def socket_path(folder: Path, name: str) -> Path:
    """Return the socket file of ``name``; raise TransportError for an invalid name."""
    if not _NAME.fullmatch(name):
        raise TransportError(
            f"a bringup cannot be named '{name}': use up to 64 letters, digits, "
            "'_', '-' and '.', a letter or digit first"
        )
    path = folder / f"{name}.sock"
    if len(os.fsencode(path)) > _MAX_PATH:
        raise TransportError(
            f"the socket path {path} is longer than {_MAX_PATH} bytes; "
            "use a shorter --name, or set XDG_RUNTIME_DIR to a shorter folder"
        )
    return path


def insecurity(folder: Path) -> str | None:
    """Return why other users could create a socket in ``folder``; None if they cannot.

    Raises:
        OSError: If the folder does not exist.
    """
    status = folder.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid():
        return f"{folder} is not a folder of this user; remove it"
    if status.st_mode & 0o077:
        return f"{folder} is open to other users; run: chmod 700 {folder}"
    return None


def is_foreign(peer: socket.socket) -> bool:
    """Return whether the other process is known to belong to another user."""
    if not hasattr(socket, "SO_PEERCRED"):
        return False
    credentials = struct.Struct("3i")
    data = peer.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, credentials.size)
    _, user, _ = credentials.unpack(data)
    return bool(user != os.getuid())


Vector3 = tuple[float, float, float]
Rotation = tuple[Vector3, Vector3, Vector3]
_IDENTITY: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
Quaternion = tuple[float, float, float, float]
_SMALL = 1e-12


def _short(value: float) -> str:
    return f"{round(value, 6) + 0.0:g}"


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

    def __repr__(self) -> str:
        """Return position and quaternion as text, rounded to 6 decimal places."""
        position = ", ".join(_short(value) for value in self.position)
        quat = ", ".join(_short(value) for value in self.quat_wxyz)
        return f"Transform(position=({position}), quat_wxyz=({quat}))"


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


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Mimic:
    """Mimic relation: position = multiplier · position of ``joint`` + offset."""

    joint: str
    """The joint that determines the position."""
    multiplier: float = 1.0
    """Factor of the position of ``joint``."""
    offset: float = 0.0
    """Position while the position of ``joint`` is 0 [rad | m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """Pose of a frame in the parent frame, in the form of URDF's ``<origin>``."""

    xyz: Vector3 = (0.0, 0.0, 0.0)
    """Position of the frame's origin [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw about fixed axes [rad]: R = Rz(yaw) Ry(pitch) Rx(roll)."""


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


@lru_cache(maxsize=1024)  # the origins of the joints of some robots, which are constant
def _at_zero(origin: Pose) -> Transform:
    return to_transform(origin) @ Transform()  # without negative zeros


class JointType(enum.Enum):
    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"
    FIXED = "fixed"
    FLOATING = "floating"
    PLANAR = "planar"


TURNING: Final = frozenset({JointType.REVOLUTE, JointType.CONTINUOUS})


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


T = TypeVar("T", float, "NDArray[np.float64]")


def joint_position(joint: Joint, position: Mapping[str, T]) -> T | float:
    """Return the position of ``joint``.

    The result is the given position, the position from the mimic relation, or 0.

    Positions are numbers or arrays.
    """
    mimic = joint.mimic
    if mimic is None or joint.name in position:
        return position.get(joint.name, 0.0)
    return mimic.multiplier * position.get(mimic.joint, 0.0) + mimic.offset


def joint_transform(joint: Joint, position: Mapping[str, float]) -> Transform:
    """Return the pose of the joint's child link in its parent link.

    ``position`` has the same meaning as for ``link_poses``.  Planar and floating joints
    always have position 0.
    """
    at_zero = _at_zero(joint.origin)
    if joint.type is JointType.PRISMATIC:
        q, (x, y, z) = joint_position(joint, position), joint.axis
        return at_zero @ Transform(position=(q * x, q * y, q * z))
    if joint.type in TURNING:
        turn = rotation_about(joint.axis, joint_position(joint, position))
        return at_zero @ Transform(rotation=turn)
    return at_zero
