"""Kinematics of the tool in n copies of an arm, vectorized over the copies."""

from __future__ import annotations

from typing import final

import numpy as np

from tool0.description.transform import Transform
from tool0.description.transform_arrays import Frames, quats_wxyz, sine_vectors
from tool0.kernel.library import load
from tool0.kernel.tool import ToolKernel
from tool0.kinematics.chain import ArmChain, Array, Posture

DAMPING = 1e-4
"""Squared damping of the Jacobian's inverse [m²].  Near a singularity, the damping
limits the joint speeds, so the tool lags behind its target."""
STEPS = 2
"""Number of Newton steps per action.  After two steps, the error of a 2 cm motion is
below 0.1 mm."""


@final
class Tool:
    """The TCP of a gripper, a frame that is fixed to the arm's flange.

    The compiled kernel computes the poses if it is available.  Otherwise, the reference
    implementation in NumPy computes the poses.
    """

    def __init__(
        self, chain: ArmChain, T_root_base: Transform, T_tip_tcp: Transform
    ) -> None:
        self._chain = chain
        self._T_root_base = Frames.of(T_root_base)
        self._T_tip_tcp = T_tip_tcp
        self._kernel: ToolKernel | None = None
        compiled = load()
        if compiled is not None:
            self._kernel = ToolKernel(
                compiled,
                base=T_root_base.matrix,
                joints=[joint.placement for joint in chain.tree],
                axes=np.array([joint.axis for joint in chain.tree]),
                tool=(chain.T_last_tip @ T_tip_tcp).matrix,
                damping=DAMPING,
            )

    def pose(self, q: Array) -> Frames:
        """Return the TCP's poses in the root frame at joint positions [rad], (n, 6)."""
        if self._kernel is not None:
            return Frames(*self._kernel.poses(q))
        return self._T_root_base @ self._in_base(self._chain.forward(q))

    def quats(self, rotations: Array) -> Array:
        """Convert rotation matrices (n, 3, 3) to quaternions (n, 4) with w >= 0."""
        if self._kernel is not None:
            return self._kernel.quats(rotations)
        return quats_wxyz(rotations)

    def _in_base(self, posture: Posture) -> Frames:
        T = posture.T_base_tip
        return Frames(T[:, :3, 3], T[:, :3, :3]) @ self._T_tip_tcp

    def steered(self, q: Array, moves: Array, lowest: float, limit: Array) -> Array:
        """Return joint positions [rad], (n, 6), after moves of a tool that points down.

        Args:
            q: Start of the motion [rad], shape (n, 6).
            moves: Translations along the root's axes [m] and rotation about z [rad],
                shape (n, 4).
            lowest: Height in the root frame below which the tool does not move down
                [m].
            limit: Largest change of each joint [rad], shape (6,); see ``approach``.
        """
        if self._kernel is not None:
            return self._kernel.steered(q, moves, lowest, limit)
        pose = self.pose(q)
        position = raised(pose.position + moves[:, :3], pose.position, lowest)
        target = Frames(position, downward(pose.yaw + moves[:, 3]))
        return self.approach(q, target, limit)

    def approach(self, q: Array, target: Frames, limit: Array) -> Array:
        """Return joint positions closer to ``target`` [rad], shape (n, 6).

        Args:
            q: Start of the motion [rad], shape (n, 6).
            target: Target pose of the tool in the root frame, about one step away.
            limit: Largest change of each joint [rad], shape (6,).  If the change of a
                joint would exceed the limit, the changes of all the copy's joints are
                scaled down together.
        """
        if self._kernel is not None:
            return self._kernel.approach(q, target.position, target.rotation, limit)
        found, R_base = q, self._T_root_base.rotation
        for _ in range(STEPS):
            posture = self._chain.forward(found)
            tcp = self._in_base(posture)
            pose = self._T_root_base @ tcp
            error = np.empty((len(q), 6))
            error[:, :3] = target.position - pose.position
            error[:, 3:] = chord_vectors(pose.rotation, target.rotation)
            J = posture.jacobian_at(tcp.position)
            J[:, :3], J[:, 3:] = R_base @ J[:, :3], R_base @ J[:, 3:]
            Jt = J.swapaxes(1, 2)
            solved = np.linalg.solve(J @ Jt + DAMPING * np.eye(6), error[:, :, None])
            found = found + (Jt @ solved)[:, :, 0]
        step = found - q
        excess = np.maximum(1.0, np.abs(step / limit).max(axis=1))
        return np.asarray(q + step / excess[:, None])


def chord_vectors(R: Array, R_wanted: Array) -> Array:
    """Return rotation vectors from R to R_wanted in root axes [rad], shape (n, 3).

    The length of a vector is close to the angle for angles below about 1 rad, and never
    exceeds 2 rad.
    """
    E = R_wanted @ R.swapaxes(1, 2)
    trace = E[:, 0, 0] + E[:, 1, 1] + E[:, 2, 2]
    # The axis times sin(angle) is divided by cos(angle/2), which gives 2 sin(angle/2).
    return np.asarray(sine_vectors(E) / np.sqrt(np.maximum(1.0 + trace, 0.04))[:, None])


def raised(position: Array, start: Array, lowest: float) -> Array:
    """Return positions [m], raised to the smaller of ``lowest`` and the start's height.

    All positions are in the root frame and have the shape (n, 3).
    """
    found = position.copy()
    found[:, 2] = np.maximum(found[:, 2], np.minimum(start[:, 2], lowest))
    return found


def downward(yaw: Array) -> Array:
    """Return rotations of a tool that points down, with its x axis at ``yaw`` [rad]."""
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.zeros((len(yaw), 3, 3))
    R[:, 0, 0], R[:, 1, 0] = c, s
    R[:, 0, 1], R[:, 1, 1] = s, -c
    R[:, 2, 2] = -1.0
    return R
