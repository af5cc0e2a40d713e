"""Coriolis and centrifugal efforts of a robot's joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from tool0.description.bodies import JointDynamics, Matrix
from tool0.description.flat_frames import Frame
from tool0.description.transform import Vector3

_ZERO: Final = (0.0, 0.0, 0.0)


def velocity_efforts(
    dynamics: JointDynamics, position: Sequence[float], velocity: Sequence[float]
) -> Matrix:
    """Return the efforts that keep the joint velocities constant in zero gravity.

    The efforts C(q, qd) qd [N·m | N], shape (n_joints,), are computed from the
    accelerations of the bodies at constant joint velocities.

    Args:
        dynamics: Dynamics of the robot.
        position: Positions of the movable joints, in the model's order [rad | m].
        velocity: Velocities of the movable joints, in the model's order [rad/s | m/s].
            The values for mimic joints are ignored, since mimic joints follow their
            master joints.
    """
    frames = dynamics.frames(position)
    efforts = np.zeros(len(frames))
    motions: list[tuple[Vector3, Vector3, Vector3]] = []
    """Angular velocity, angular acceleration and linear acceleration of each body's
    frame."""
    for i, (frame, body) in enumerate(zip(frames, dynamics.table.bodies, strict=True)):
        omega, alpha, a = _carried(frames, motions, i, body.parent)
        speed = body.multiplier * velocity[body.master]
        rate = (speed * frame[6], speed * frame[7], speed * frame[8])
        turn = _cross(omega, rate)
        if body.is_prismatic:
            a = _sum(a, turn, turn)
        else:
            omega, alpha = _sum(omega, rate), _sum(alpha, turn)
        motions.append((omega, alpha, a))
        lever = _rotated(frame, body.center)
        x, y, z = (p + q for p, q in zip(frame[9:], lever, strict=True))
        linear, angular = dynamics.jacobian(frames, i, (x, y, z))
        R = np.array(frame[:9]).reshape(3, 3).T
        tensor = R @ dynamics.tensors[i] @ R.T
        x, y, z = (tensor @ omega).tolist()
        force = body.mass * np.array(_sum(a, *_relative(omega, alpha, lever)))
        efforts += linear @ force
        efforts += angular @ (tensor @ alpha + _cross(omega, (x, y, z)))
    return efforts


def _carried(
    frames: Sequence[Frame],
    motions: Sequence[tuple[Vector3, Vector3, Vector3]],
    body: int,
    parent: int,
) -> tuple[Vector3, Vector3, Vector3]:
    """Return the motion of the parent at the origin of a body's frame."""
    if parent < 0:
        return _ZERO, _ZERO, _ZERO
    omega, alpha, a = motions[parent]
    x, y, z = (p - q for p, q in zip(frames[body][9:], frames[parent][9:], strict=True))
    return omega, alpha, _sum(a, *_relative(omega, alpha, (x, y, z)))


def _relative(omega: Vector3, alpha: Vector3, way: Vector3) -> tuple[Vector3, Vector3]:
    """Return the tangential and centripetal accelerations at an offset [m/s²]."""
    return _cross(alpha, way), _cross(omega, _cross(omega, way))


def _cross(a: Vector3, b: Vector3) -> Vector3:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _sum(*vectors: Vector3) -> Vector3:
    x, y, z = map(sum, zip(*vectors, strict=True))
    return x, y, z


def _rotated(frame: Frame, vector: Vector3) -> Vector3:
    """Return a vector, given in a body's frame, in the axes of the root."""
    ax, ay, az, bx, by, bz, cx, cy, cz = frame[:9]
    x, y, z = vector
    return (
        ax * x + bx * y + cx * z,
        ay * x + by * y + cy * z,
        az * x + bz * y + cz * z,
    )
