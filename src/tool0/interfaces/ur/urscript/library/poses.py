"""Module urmath: poses and rotations."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from tool0.interfaces.ur.pose import matrix_of, pose_of, rotation_of, rotation_vector
from tool0.interfaces.ur.urscript.functions import Function, function
from tool0.interfaces.ur.urscript.kinds import Number, PoseLike, Spatial, Vector
from tool0.interfaces.ur.urscript.values import Pose, Value
from tool0.kinematics.chain import Array


def pose_trans(p_from: PoseLike, p_from_to: PoseLike) -> Pose:
    """Return a pose that is given in another one."""
    return Pose(pose_of(matrix_of(p_from) @ matrix_of(p_from_to)))


def pose_inv(p_from: PoseLike) -> Pose:
    """Return the inverse of a pose."""
    return Pose(pose_of(np.asarray(np.linalg.inv(matrix_of(p_from)))))


def pose_add(p_1: PoseLike, p_2: PoseLike) -> Pose:
    """Return the sum of the positions, with the product of the rotations."""
    return _pose(
        [a + b for a, b in zip(p_1[:3], p_2[:3], strict=True)],
        rotation_of(p_1[3:]) @ rotation_of(p_2[3:]),
    )


def pose_sub(p_to: PoseLike, p_from: PoseLike) -> Pose:
    """Return what ``pose_add`` adds to ``p_from`` to get ``p_to``."""
    return _pose(
        [a - b for a, b in zip(p_to[:3], p_from[:3], strict=True)],
        rotation_of(p_from[3:]).T @ rotation_of(p_to[3:]),
    )


def pose_dist(p_from: PoseLike, p_to: PoseLike) -> float:
    """Return the norm of the difference of two poses [m and rad]."""
    return math.hypot(*pose_sub(p_to, p_from))


def point_dist(p_from: PoseLike, p_to: PoseLike) -> float:
    """Return the distance of two positions [m]."""
    return math.dist(p_from[:3], p_to[:3])


def interpolate_pose(p_from: PoseLike, p_to: PoseLike, alpha: Number) -> Pose:
    """Return a pose on the straight line, with the rotation on its geodesic."""
    step = Pose(alpha * x for x in pose_sub(p_to, p_from))
    return pose_add(p_from, step)


def wrench_trans(T_from_to: PoseLike, w_from: Spatial) -> Value:
    """Return a wrench that is given in another frame and about its origin."""
    R = rotation_of(T_from_to[3:]).T
    force = np.asarray(w_from[:3])
    torque = np.asarray(w_from[3:]) - np.cross(T_from_to[:3], force)
    return tuple([*(R @ force).tolist(), *(R @ torque).tolist()])


def rotvec2rpy(rotation_vector: Vector) -> Value:
    """Return roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    R = rotation_of(rotation_vector)
    pitch = math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0]))
    if math.hypot(R[0, 0], R[1, 0]) < 1e-9:  # gimbal lock: roll and yaw are one
        return (0.0, pitch, math.atan2(-R[0, 1], R[1, 1]))
    roll, yaw = math.atan2(R[2, 1], R[2, 2]), math.atan2(R[1, 0], R[0, 0])
    return (roll, pitch, yaw)


def rpy2rotvec(rpy_vector: Vector) -> Value:
    """Return the rotation vector of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    roll, pitch, yaw = rpy_vector
    R = (
        rotation_of((0.0, 0.0, yaw))
        @ rotation_of((0.0, pitch, 0.0))
        @ rotation_of((roll, 0.0, 0.0))
    )
    return tuple(rotation_vector(R).tolist())


def _pose(position: list[float], R: Array) -> Pose:
    return Pose([*position, *rotation_vector(R).tolist()])


FUNCTIONS: Final[tuple[Function, ...]] = tuple(
    function(item)
    for item in (
        *(interpolate_pose, point_dist, pose_add, pose_dist, pose_inv, pose_sub),
        *(pose_trans, rotvec2rpy, rpy2rotvec, wrench_trans),
    )
)
