"""Kinematics and dynamics of an arm, in the base frame of UR, for its motion laws."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Final, final

from tool0.control.arm.model import ArmDynamics, Placement
from tool0.description.model import FLANGE, RobotModel
from tool0.hardware.engine import JointState
from tool0.hardware.robot_hardware import RobotHardware

if TYPE_CHECKING:
    from tool0.kinematics.chain import ArmChain, Array


MASS_PERIOD: Final = 0.032
"""Time between updates of the mass matrix [s]; a wrist turns 0.1 rad in it."""


@final
class ArmMechanics:
    """Poses, Jacobians, masses and weights of one arm.

    The base frame is the link ``<prefix>base``, base_link turned by pi about z, as the
    arm's control box has it; without such a link, it is the link that carries the arm.
    """

    def __init__(self, model: RobotModel, arm: str, hardware: RobotHardware) -> None:
        """Compute nothing yet: numpy is only needed by some requests."""
        self._model, self._arm, self._hardware = model, arm, hardware
        self._masses: tuple[float, Array] | None = None
        """Time for which the mass matrix was computed [s], and the matrix."""

    @cached_property
    def chain(self) -> ArmChain:
        """Its six joints."""
        from tool0.kinematics.chain import find_chains

        return find_chains(self._model)[self._arm]

    @cached_property
    def T_base_chain(self) -> Array:
        """The link that carries the arm in the base frame, shape (4, 4)."""
        import numpy as np

        from tool0.kinematics.chain import fixed_transform

        base = self.chain.tip.removesuffix(FLANGE) + "base"
        if all(link.name != base for link in self._model.links):
            return np.eye(4)
        return fixed_transform(self._model, base, self.chain.base).matrix

    def place(self, q: Array, lever: Array) -> Placement:
        """Return where the point ``lever`` of the flange is at ``q`` [rad]."""
        import numpy as np

        posture, base = self.chain.forward(q[None]), self.T_base_chain
        T, R = posture.T_base_tip[0], base[:3, :3]
        point = T[:3, 3] + T[:3, :3] @ lever
        x, y, z = axes = posture.axes[0].T
        rx, ry, rz = point[:, None] - posture.points[0].T
        linear = np.array([y * rz - z * ry, z * rx - x * rz, x * ry - y * rx])
        J = np.concatenate([R @ linear, R @ axes])
        return Placement(base[:3, 3] + R @ point, R @ T[:3, :3], J)

    def rotors(self) -> list[float]:
        """Return the inertias of the rotors, which ``dynamics`` lacks [kg·m²]."""
        return list(map(self._hardware.rotor_inertia, self.chain.joint_names))

    def dynamics(self, state: JointState) -> ArmDynamics:
        """Return the mass matrix of the joints, and the efforts that hold them."""
        import numpy as np

        names, hardware = self.chain.joint_names, self._hardware
        known = self._masses
        if known is None or not 0.0 <= state.time - known[0] < MASS_PERIOD:
            self._masses = known = state.time, hardware.masses_of(names, state)
        return ArmDynamics(known[1], np.array(hardware.weights_of(names, state)))
