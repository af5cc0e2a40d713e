"""Moves to plan for, and the laws that every planned motion obeys."""

from __future__ import annotations

import numpy as np

from tool0.description.transform_arrays import matrix_of, rotation_vector
from tool0.kinematics.chain import Array
from tool0.kinematics.inverse import InverseKinematics
from tool0.motion.moves import Move, MovePlan
from tool0.motion.planner import MovePlanner

HOME = np.array([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])
TCP = (0.01, -0.02, 0.15, 0.2, 0.0, 0.3)
HARDEST = 40.0 * 1.01
"""Largest acceleration of a joint [rad/s²]: the planner's limit, and rounding."""


class MovesRig:
    """One arm with a tool at HOME."""

    def __init__(self, kinematics: InverseKinematics, start: Array = HOME) -> None:
        self.kinematics = kinematics
        self.start = start
        self.T_tip_tool = matrix_of(TCP)
        self.planner = MovePlanner(kinematics, TCP)
        self.home = self.tool(start[None])[0]

    def tool(self, q: Array) -> Array:
        """Return poses of the tool, shape (n, 4, 4)."""
        return np.asarray(self.kinematics.chain.forward(q).T_base_tip @ self.T_tip_tool)

    def pose(self, xyz: object, turn: object = (0.0, 0.0, 0.0)) -> list[float]:
        """Return a pose displaced from HOME, in the axes of the base."""
        R = matrix_of([0.0, 0.0, 0.0, *turn])[:3, :3] @ self.home[:3, :3]  # type: ignore[misc]
        p = self.home[:3, 3] + np.asarray(xyz)
        return [*p.tolist(), *rotation_vector(R).tolist()]

    def joint(self, change: object, **options: object) -> Move:
        q = self.start + np.asarray(change)
        return Move(
            kind="joint", q=tuple(q.tolist()), **({"a": 1.4, "v": 1.05} | options)
        )  # type: ignore[arg-type]

    def tool_move(
        self,
        xyz: object,
        turn: object = (0.0, 0.0, 0.0),
        kind: str = "linear",
        **options: object,
    ) -> Move:
        pose = self.pose(xyz, turn)
        return Move(kind=kind, pose=pose, **({"a": 1.2, "v": 0.25} | options))  # type: ignore[arg-type]

    def plan(self, *moves: Move) -> MovePlan:
        return self.planner.plan(self.start, moves)

    def played(self, plan: MovePlan, n: int = 2001) -> tuple[Array, Array, Array]:
        """Return times [s], the tool's poses and its speeds [m/s] there."""
        times = np.linspace(0.0, plan.duration, n)
        motion = plan.path.at(times)
        posture = self.kinematics.chain.forward(motion.positions)
        T = posture.T_base_tip @ self.T_tip_tool
        V = (posture.jacobian @ motion.velocities[..., None])[..., 0]
        lever = T[:, :3, 3] - posture.T_base_tip[:, :3, 3]
        return times, T, V[:, :3] + np.cross(V[:, 3:], lever)

    def check(self, plan: MovePlan) -> None:
        """Check that a motion is smooth, ends at rest and stays within the limits."""
        path = plan.path
        times, q, qd = path.times, path.positions, path.velocities
        assert times[0] == 0.0
        assert (np.diff(times) > 0.0).all()
        assert np.isfinite(q).all()
        assert not qd[-1].any()
        if len(times) == 1:
            return
        dense = np.linspace(0.0, plan.duration, max(2001, int(plan.duration / 1e-3)))
        motion = path.at(dense)
        step = dense[1]
        # Velocity is the derivative of position, and its slope is bounded: both are
        # continuous.
        middle = path.at((dense[1:] + dense[:-1]) / 2.0)
        slope = np.diff(motion.positions, axis=0) / step
        assert np.abs(slope - middle.velocities).max() < HARDEST * step
        assert np.abs(np.diff(motion.velocities, axis=0)).max() < HARDEST * step
        fastest = self.kinematics.fastest
        assert (np.abs(motion.velocities) <= fastest).all()
        mean = np.diff(q, axis=0) / np.diff(times)[:, None]
        assert (np.abs(mean) <= fastest).all()
        assert (motion.positions >= self.kinematics.lower - 1e-6).all()
        assert (motion.positions <= self.kinematics.upper + 1e-6).all()
        assert list(plan.begins) == sorted(plan.begins)
        assert all(b <= z for b, z in zip(plan.begins, plan.zones, strict=True))
