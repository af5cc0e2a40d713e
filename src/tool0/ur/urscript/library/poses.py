"""Functions of URScript's module urmath for poses and rotations."""

from __future__ import annotations

import math
from typing import Final

from tool0.description.transform import Pose as Origin
from tool0.description.transform import (
    Transform,
    cross,
    from_rotation_vector,
    to_pose,
    to_transform,
)
from tool0.ur.pose import pose_of, transform_of
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import Number, PoseLike, Spatial, Vector
from tool0.ur.urscript.values import Pose, Value


def pose_trans(p_from: PoseLike, p_from_to: PoseLike) -> Pose:
    """Return the product of the transforms ``p_from`` and ``p_from_to``."""
    return Pose(pose_of(transform_of(p_from) @ transform_of(p_from_to)))


def pose_inv(p_from: PoseLike) -> Pose:
    """Return the inverse of a pose."""
    return Pose(pose_of(transform_of(p_from).inverse()))


def pose_add(p_1: PoseLike, p_2: PoseLike) -> Pose:
    """Return a pose with the sum of positions and the product of rotations."""
    return _pose(
        [a + b for a, b in zip(p_1[:3], p_2[:3], strict=True)],
        transform_of(p_1) @ transform_of(p_2),
    )


def pose_sub(p_to: PoseLike, p_from: PoseLike) -> Pose:
    """Return the pose that ``pose_add`` must add to ``p_from`` to get ``p_to``."""
    return _pose(
        [a - b for a, b in zip(p_to[:3], p_from[:3], strict=True)],
        transform_of(p_from).inverse() @ transform_of(p_to),
    )


def pose_dist(p_from: PoseLike, p_to: PoseLike) -> float:
    """Return the norm of the difference of two poses in m and rad."""
    return math.hypot(*pose_sub(p_to, p_from))


def point_dist(p_from: PoseLike, p_to: PoseLike) -> float:
    """Return the distance between two positions [m]."""
    return math.dist(p_from[:3], p_to[:3])


def interpolate_pose(p_from: PoseLike, p_to: PoseLike, alpha: Number) -> Pose:
    """Interpolate the position linearly, and the rotation along the geodesic."""
    step = Pose(alpha * x for x in pose_sub(p_to, p_from))
    return pose_add(p_from, step)


def wrench_trans(T_from_to: PoseLike, w_from: Spatial) -> Value:
    """Return a wrench in another frame, with moments about the origin of that frame."""
    T = transform_of(T_from_to).inverse()
    fx, fy, fz, tx, ty, tz = w_from
    mx, my, mz = cross(transform_of(T_from_to).position, (fx, fy, fz))
    return (*T.rotate((fx, fy, fz)), *T.rotate((tx - mx, ty - my, tz - mz)))


def rotvec2rpy(rotation_vector: Vector) -> Value:
    """Return roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    return to_pose(from_rotation_vector((0.0, 0.0, 0.0), rotation_vector)).rpy


def rpy2rotvec(rpy_vector: Vector) -> Value:
    """Return the rotation vector of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    roll, pitch, yaw = rpy_vector
    return to_transform(Origin(rpy=(roll, pitch, yaw))).rotation_vector


def _pose(position: list[float], rotation: Transform) -> Pose:
    return Pose([*position, *rotation.rotation_vector])


FUNCTIONS: Final[tuple[Function, ...]] = tuple(
    function(item)
    for item in (
        *(interpolate_pose, point_dist, pose_add, pose_dist, pose_inv, pose_sub),
        *(pose_trans, rotvec2rpy, rpy2rotvec, wrench_trans),
    )
)
