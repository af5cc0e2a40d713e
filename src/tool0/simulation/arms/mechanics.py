"""Kinematics and dynamics of an arm for its motion laws, in UR's base frame."""

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
"""Time between updates of the mass matrix [s].  A wrist joint turns by up to 0.1 rad
between two updates."""


@final
class ArmMechanics:
    """Poses, Jacobians, mass matrices and gravity efforts of one arm.

    The base frame is the link ``<prefix>base``: base_link rotated by π about z, as in
    the arm's control box.  If there is no link ``<prefix>base``, the base frame is the
    link that carries the arm.
    """

    def __init__(self, model: RobotModel, arm: str, hardware: RobotHardware) -> None:
        """Initialize without computations, since only some requests need numpy."""
        self._model, self._arm, self._hardware = model, arm, hardware
        self._masses: tuple[float, Array] | None = None
        """Time of the last mass matrix [s], and the matrix."""

    @cached_property
    def chain(self) -> ArmChain:
        """The six joints of the arm."""
        from tool0.kinematics.chain import find_chains

        return find_chains(self._model)[self._arm]

    @cached_property
    def T_base_chain(self) -> Array:
        """Pose of the link that carries the arm, in the base frame, shape (4, 4)."""
        import numpy as np

        from tool0.kinematics.chain import fixed_transform

        base = self.chain.tip.removesuffix(FLANGE) + "base"
        if all(link.name != base for link in self._model.links):
            return np.eye(4)
        return fixed_transform(self._model, base, self.chain.base).matrix

    def place(self, q: Array, lever: Array) -> Placement:
        """Return the placement of a point at the joint positions ``q`` [rad].

        ``lever`` is the position of the point in the flange frame [m].
        """
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
        """Return the rotor inertias, which ``dynamics`` does not include [kg·m²]."""
        return list(map(self._hardware.rotor_inertia, self.chain.joint_names))

    def dynamics(self, state: JointState) -> ArmDynamics:
        """Return the joints' mass matrix, and the efforts that balance gravity."""
        import numpy as np

        names, hardware = self.chain.joint_names, self._hardware
        known = self._masses
        if known is None or not 0.0 <= state.time - known[0] < MASS_PERIOD:
            self._masses = known = state.time, hardware.masses_of(names, state)
        return ArmDynamics(known[1], np.array(hardware.weights_of(names, state)))
