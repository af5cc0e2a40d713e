"""UR's poses: a position and a rotation vector, p[x, y, z, rx, ry, rz]."""

from __future__ import annotations

from tool0.kinematics.chain import Array
from tool0.kinematics.pose import matrix_of, rotation_of, rotation_vector
from tool0.protocol.updates import Six

__all__ = ["matrix_of", "pose_of", "rotation_of", "rotation_vector"]


def pose_of(T: Array) -> Six:
    """Return a homogeneous matrix as a pose."""
    x, y, z = T[:3, 3].tolist()
    rx, ry, rz = rotation_vector(T[:3, :3]).tolist()
    return (x, y, z, rx, ry, rz)
