"""Conversions between the frames of a UR's reports and those of the description."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, final

from tool0.description.model import FLANGE, RobotModel
from tool0.description.parts import ArmParts
from tool0.description.scene_state import Wrench

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@final
class FlangeFrames:
    """Converter of an arm's poses and wrenches, which are reported in ``base``."""

    def __init__(self, model: RobotModel, arm: ArmParts) -> None:
        self._model, self._arm = model, arm

    @cached_property
    def _base(self) -> str:
        """Frame of the reports: REP-199's ``base``, or the root if it is missing."""
        prefix = self._arm.flange.removesuffix(FLANGE)
        name = f"{prefix}base"
        return name if name in self._model.link_by_name else self._model.root

    def flange(self, positions: Sequence[float]) -> Array:
        """Return the flange's pose in the base at joint positions [rad], (4, 4)."""
        from tool0.description.forward_kinematics import link_poses

        names = [joint.name for joint in self._arm.joints]
        poses = link_poses(self._model, dict(zip(names, positions, strict=True)))
        return (poses[self._base].inverse() @ poses[self._arm.flange]).matrix

    def reported_flange(self, tcp_pose: Sequence[float], tcp: Sequence[float]) -> Array:
        """Return the flange's pose in the base for a reported TCP pose and TCP offset.

        Each argument consists of a position and a rotation vector [m, rad].
        """
        import numpy as np

        from tool0.description.transform_arrays import matrix_of

        found: Array = matrix_of(tcp_pose) @ np.linalg.inv(matrix_of(tcp))
        return found

    def at_flange(
        self, wrench: Sequence[float], tcp: Sequence[float], positions: Sequence[float]
    ) -> Wrench:
        """Return the wrench at the flange for a wrench at the TCP in the base's axes.

        The resulting wrench is in the flange's axes [N, N·m].
        """
        import numpy as np

        R = self.flange(positions)[:3, :3]
        force, torque = R.T @ np.asarray(wrench[:3]), R.T @ np.asarray(wrench[3:])
        torque = torque + np.cross(np.asarray(tcp[:3]), force)
        fx, fy, fz = map(float, force)
        tx, ty, tz = map(float, torque)
        return fx, fy, fz, tx, ty, tz
