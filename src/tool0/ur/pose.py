"""UR's poses: a position and a rotation vector, p[x, y, z, rx, ry, rz]."""

from __future__ import annotations

from collections.abc import Sequence

from tool0.description.transform import Transform, from_rotation_vector
from tool0.protocol.state import Six


def transform_of(pose: Sequence[float]) -> Transform:
    """Convert a UR pose to a transform."""
    return from_rotation_vector(pose[:3], pose[3:])


def pose_of(T: Transform) -> Six:
    """Convert a transform to a UR pose."""
    return (*T.position, *T.rotation_vector)
