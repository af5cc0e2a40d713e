"""Kinematics of the tool of n copies of an arm, vectorized over the copies."""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from tool0.description.transform import Transform
from tool0.kinematics.chain import ArmChain, Array

DAMPING = 1e-4
"""Of the Jacobian's inverse, squared [m²]: near a singularity the tool lags instead of
the joints racing."""
STEPS = 2
"""Newton steps per action: the second leaves less than 0.1 mm of a step of 2 cm."""


class ToolPose(NamedTuple):
    """Poses of the tool in the root, one per copy."""

    position: Array
    """[m], shape (n, 3)."""
    rotation: Array
    """Rotation matrices, shape (n, 3, 3)."""

    @property
    def yaw(self) -> Array:
        """Angle of its x axis about the root's z [rad], shape (n,)."""
        return np.arctan2(self.rotation[:, 1, 0], self.rotation[:, 0, 0])


@final
class Tool:
    """The tcp of a gripper: a frame fixed in the arm's flange."""

    def __init__(
        self, chain: ArmChain, T_root_base: Transform, T_tip_tcp: Transform
    ) -> None:
        self._chain = chain
        base, tcp = T_root_base.matrix, T_tip_tcp.matrix
        self._R_base, self._p_base = base[:3, :3].copy(), base[:3, 3].copy()
        self._R_tcp, self._p_tcp = tcp[:3, :3].copy(), tcp[:3, 3].copy()

    def pose(self, q: Array) -> ToolPose:
        """Return the poses at joint positions ``q`` [rad], shape (n, 6)."""
        T = self._chain.forward(q).T_base_tip
        return self._in_root(T)

    def _in_root(self, T_base_tip: Array) -> ToolPose:
        R = T_base_tip[:, :3, :3]
        p = T_base_tip[:, :3, 3] + R @ self._p_tcp
        return ToolPose(
            self._p_base + (self._R_base @ p[:, :, None])[:, :, 0],
            self._R_base @ (R @ self._R_tcp),
        )

    def approach(self, q: Array, target: ToolPose, limit: Array) -> Array:
        """Return positions nearer to ``target`` [rad], shape (n, 6).

        Args:
            q: Where to start [rad], shape (n, 6).
            target: Where the tool is to go: a step away.
            limit: Largest change of each joint [rad], shape (6,).  Beyond it all joints
                of a copy move a shorter way along the same line.
        """
        found = q
        for _ in range(STEPS):
            posture = self._chain.forward(found)
            pose = self._in_root(posture.T_base_tip)
            error = np.empty((len(q), 6))
            error[:, :3] = target.position - pose.position
            error[:, 3:] = rotation_vector(pose.rotation, target.rotation)
            lever = (
                posture.T_base_tip[:, None, :3, 3]
                + (posture.T_base_tip[:, :3, :3] @ self._p_tcp)[:, None]
                - posture.points
            )
            J = np.empty((len(q), 6, 6))
            J[:, :3] = (np.cross(posture.axes, lever) @ self._R_base.T).swapaxes(1, 2)
            J[:, 3:] = (posture.axes @ self._R_base.T).swapaxes(1, 2)
            Jt = J.swapaxes(1, 2)
            solved = np.linalg.solve(J @ Jt + DAMPING * np.eye(6), error[:, :, None])
            found = found + (Jt @ solved)[:, :, 0]
        step = found - q
        excess = np.maximum(1.0, np.abs(step / limit).max(axis=1))
        return np.asarray(q + step / excess[:, None])


def rotation_vector(R: Array, R_wanted: Array) -> Array:
    """Return the turn from R to R_wanted in the root's axes [rad], shape (n, 3).

    Its length is that of the angle below about 1 rad, and never above 2.
    """
    E = R_wanted @ R.swapaxes(1, 2)
    sine = np.empty((len(R), 3))
    sine[:, 0] = E[:, 2, 1] - E[:, 1, 2]
    sine[:, 1] = E[:, 0, 2] - E[:, 2, 0]
    sine[:, 2] = E[:, 1, 0] - E[:, 0, 1]
    trace = E[:, 0, 0] + E[:, 1, 1] + E[:, 2, 2]
    # The axis times 2 sin(angle/2), from sin(angle): their ratio is 1 / cos(angle/2).
    return np.asarray(sine / np.sqrt(np.maximum(1.0 + trace, 0.04))[:, None])


def turned_by(vectors: Array) -> Array:
    """Return rotations by rotation vectors [rad], (n, 3), as matrices (n, 3, 3)."""
    angle = np.sqrt((vectors * vectors).sum(axis=1))
    axis = vectors / np.maximum(angle, 1e-12)[:, None]
    K = np.zeros((len(vectors), 3, 3))
    K[:, 0, 1], K[:, 0, 2] = -axis[:, 2], axis[:, 1]
    K[:, 1, 0], K[:, 1, 2] = axis[:, 2], -axis[:, 0]
    K[:, 2, 0], K[:, 2, 1] = -axis[:, 1], axis[:, 0]
    sine, versine = np.sin(angle)[:, None, None], 1.0 - np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + sine * K + versine * (K @ K))


def downward(yaw: Array) -> Array:
    """Return rotations of a tool that looks down, its x axis at ``yaw`` [rad], (n,)."""
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.zeros((len(yaw), 3, 3))
    R[:, 0, 0], R[:, 1, 0] = c, s
    R[:, 0, 1], R[:, 1, 1] = s, -c
    R[:, 2, 2] = -1.0
    return R


def quaternions(R: Array) -> Array:
    """Return rotation matrices, (n, 3, 3), as quaternions w, x, y, z, w >= 0."""
    trace = R[:, 0, 0] + R[:, 1, 1] + R[:, 2, 2]
    squares = np.stack([trace, *(2.0 * R[:, k, k] - trace for k in range(3))], axis=1)
    largest = squares.argmax(axis=1)
    pairs = {
        (0, 1): R[:, 2, 1] - R[:, 1, 2],
        (0, 2): R[:, 0, 2] - R[:, 2, 0],
        (0, 3): R[:, 1, 0] - R[:, 0, 1],
        (1, 2): R[:, 0, 1] + R[:, 1, 0],
        (1, 3): R[:, 0, 2] + R[:, 2, 0],
        (2, 3): R[:, 1, 2] + R[:, 2, 1],
    }
    table = np.empty((len(R), 4, 4))
    for k in range(4):
        table[:, k, k] = 1.0 + squares[:, k]
    for (i, j), value in pairs.items():
        table[:, i, j] = table[:, j, i] = value
    quat = table[np.arange(len(R)), largest]
    quat = quat / np.sqrt((quat * quat).sum(axis=1))[:, None]
    return np.asarray(np.where(quat[:, :1] < 0.0, -quat, quat))
