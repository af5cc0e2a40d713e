"""Where the links are: forward kinematics of a ``RobotModel``, in plain floats."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from tool0.description.model import Joint, JointType, Pose, RobotModel, Vector3
from tool0.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Quaternion = tuple[float, float, float, float]
Rotation = tuple[Vector3, Vector3, Vector3]

_IDENTITY: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Transform:
    """The pose of one frame in another: ``T_a_c = T_a_b @ T_b_c``."""

    position: Vector3 = (0.0, 0.0, 0.0)
    """[m]"""
    rotation: Rotation = _IDENTITY
    """Rows of the rotation matrix."""

    def __matmul__(self, other: Transform) -> Transform:
        """Return the pose of ``other``'s frame in the frame that this one is in."""
        x, y, z = self.apply(other.position)
        columns = tuple(zip(*other.rotation, strict=True))
        rows = tuple(
            tuple(sum(a * b for a, b in zip(row, column)) for column in columns)  # noqa: B905
            for row in self.rotation
        )
        return Transform(position=(x, y, z), rotation=rows)  # type: ignore[arg-type]

    def apply(self, point: Vector3) -> Vector3:
        """Return ``point``, given in this frame, in the frame around it."""
        x, y, z = point
        px, py, pz = self.position
        a, b, c = self.rotation
        return (
            px + a[0] * x + a[1] * y + a[2] * z,
            py + b[0] * x + b[1] * y + b[2] * z,
            pz + c[0] * x + c[1] * y + c[2] * z,
        )

    def inverse(self) -> Transform:
        """Return the transform that undoes this one."""
        a, b, c = zip(*self.rotation, strict=True)
        turned = Transform(rotation=(a, b, c))
        x, y, z = turned.apply(self.position)
        return Transform(position=(-x, -y, -z), rotation=turned.rotation)

    @property
    def quat_wxyz(self) -> Quaternion:
        """The rotation as a unit quaternion with w >= 0."""
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = self.rotation
        # Take the root of the largest component, so that none is divided by ~0.
        squares = (
            1 + xx + yy + zz,
            1 + xx - yy - zz,
            1 - xx + yy - zz,
            1 - xx - yy + zz,
        )
        largest = squares.index(max(squares))
        root = 2 * math.sqrt(squares[largest])
        rows = (
            (root / 4, (zy - yz) / root, (xz - zx) / root, (yx - xy) / root),
            ((zy - yz) / root, root / 4, (xy + yx) / root, (xz + zx) / root),
            ((xz - zx) / root, (xy + yx) / root, root / 4, (yz + zy) / root),
            ((yx - xy) / root, (xz + zx) / root, (yz + zy) / root, root / 4),
        )
        w, x, y, z = rows[largest]
        return (w, x, y, z) if w >= 0 else (-w, -x, -y, -z)

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The homogeneous matrix, shape (4, 4)."""
        import numpy as np

        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self.position
        return matrix

    def __repr__(self) -> str:
        """Return position and quaternion, rounded to the micrometre."""
        position = ", ".join(_short(value) for value in self.position)
        quat = ", ".join(_short(value) for value in self.quat_wxyz)
        return f"Transform(position=({position}), quat_wxyz=({quat}))"


def transforms(
    model: RobotModel, position: Mapping[str, float] | None = None
) -> dict[str, Transform]:
    """Return the pose of every link in the root link.

    Args:
        model: The robot.
        position: Joint positions [rad | m] by name.  A joint left out is at 0, or
            follows the one it mimics.

    Raises:
        ModelError: If ``position`` names a joint that the robot lacks.
    """
    given = position or {}
    unknown = given.keys() - model.joint_by_name.keys()
    if unknown:
        name = sorted(unknown)[0]
        hint = did_you_mean(name, list(model.joint_by_name))
        raise ModelError(f"unknown joint '{name}'{hint}")
    found = {model.root: Transform()}
    for joint in model.joints:
        found[joint.child] = found[joint.parent] @ joint_transform(joint, given)
    return found


def joint_transform(joint: Joint, position: Mapping[str, float]) -> Transform:
    """Return the pose of the joint's child link in its parent link.

    Args:
        joint: The joint.
        position: Joint positions [rad | m] by name, as for ``transforms``.
    """
    return to_transform(joint.origin) @ _motion(joint, position)


def link_pose(
    model: RobotModel,
    position: Mapping[str, float],
    link: str,
    relative_to: str | None = None,
) -> Transform:
    """Return the pose of ``link`` in ``relative_to``; None means the root link."""
    found = transforms(model, position)
    T_root_link = found[model.link(link).name]
    if relative_to is None:
        return T_root_link
    return found[model.link(relative_to).name].inverse() @ T_root_link


def to_transform(pose: Pose) -> Transform:
    """Return ``pose``, an ``<origin>`` of URDF, as a transform."""
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


def joint_position(joint: Joint, position: Mapping[str, float]) -> float:
    """Return where ``joint`` is: as given, as what it mimics is, or at 0."""
    if joint.name in position:
        return position[joint.name]
    if joint.mimic is None:
        return 0.0
    return joint.mimic.multiplier * position.get(joint.mimic.joint, 0.0) + (
        joint.mimic.offset
    )


def _motion(joint: Joint, position: Mapping[str, float]) -> Transform:
    """Return what ``joint`` adds to its origin; planar and floating ones rest at 0."""
    q = joint_position(joint, position)
    x, y, z = joint.axis
    if joint.type is JointType.PRISMATIC:
        return Transform(position=(q * x, q * y, q * z))
    if joint.type not in {JointType.REVOLUTE, JointType.CONTINUOUS}:
        return Transform()
    c, s = math.cos(q), math.sin(q)
    v = 1.0 - c
    return Transform(  # Rodrigues' formula
        rotation=(
            (c + x * x * v, x * y * v - z * s, x * z * v + y * s),
            (y * x * v + z * s, c + y * y * v, y * z * v - x * s),
            (z * x * v - y * s, z * y * v + x * s, c + z * z * v),
        )
    )


def _short(value: float) -> str:
    return f"{round(value, 6) + 0.0:g}"
