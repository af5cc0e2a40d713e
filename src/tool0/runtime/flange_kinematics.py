"""The kinematics of an arm's flange in the base frame of UR, for its control box."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, final

from tool0.description.model import FLANGE, RobotModel

if TYPE_CHECKING:
    from tool0.kinematics.chain import ArmChain, Array, Posture


@final
class FlangeKinematics:
    """Poses and Jacobians of one arm.

    The base frame is the link ``<prefix>base``, base_link turned by pi about z, as the
    arm's control box has it; without such a link, it is the link that carries the arm.
    """

    def __init__(self, model: RobotModel, arm: str) -> None:
        """Compute nothing yet: numpy is only needed by some requests."""
        self._model, self._arm = model, arm

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

    def pose(self, q: Sequence[float]) -> Array:
        """Return the flange in the base frame at ``q`` [rad], shape (4, 4)."""
        T: Array = self.T_base_chain @ self._posture(q).T_base_tip[0]
        return T

    def jacobian(self, q: Sequence[float], lever: Array) -> Array:
        """Return the twist of a point fixed to the flange per joint velocity.

        ``lever`` is the point in the flange's frame [m].  The result is linear above
        angular, in the base's axes, shape (6, 6).
        """
        import numpy as np

        posture = self._posture(q)
        J = posture.jacobian[0]
        arm = posture.T_base_tip[0, :3, :3] @ lever
        R = self.T_base_chain[:3, :3]
        linear = J[:3] + np.cross(J[3:], arm, axisa=0).T
        return np.concatenate([R @ linear, R @ J[3:]])

    def _posture(self, q: Sequence[float]) -> Posture:
        import numpy as np

        return self.chain.forward(np.asarray([q], dtype=np.float64))
