"""Conversions between the frames in which a UR reports and the description's frames."""

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
    """Converts poses and forces of one arm, which a UR reports in its ``base``."""

    def __init__(self, model: RobotModel, arm: ArmParts) -> None:
        self._model, self._arm = model, arm

    @cached_property
    def _base(self) -> str:
        """The frame in which a UR reports: REP-199's ``base``, or else the root."""
        prefix = self._arm.flange.removesuffix(FLANGE)
        name = f"{prefix}base"
        return name if name in self._model.link_by_name else self._model.root

    def flange(self, positions: Sequence[float]) -> Array:
        """Return the flange's pose in the base for joints [rad], shape (4, 4)."""
        from tool0.description.forward_kinematics import link_poses

        names = [joint.name for joint in self._arm.joints]
        poses = link_poses(self._model, dict(zip(names, positions, strict=True)))
        return (poses[self._base].inverse() @ poses[self._arm.flange]).matrix

    def reported_flange(self, tcp_pose: Sequence[float], tcp: Sequence[float]) -> Array:
        """Return the flange's pose in the base from a reported TCP pose and TCP offset.

        Both arguments are positions and rotation vectors [m, rad].
        """
        import numpy as np

        from tool0.description.transform_arrays import matrix_of

        found: Array = matrix_of(tcp_pose) @ np.linalg.inv(matrix_of(tcp))
        return found

    def at_flange(
        self, wrench: Sequence[float], tcp: Sequence[float], positions: Sequence[float]
    ) -> Wrench:
        """Return a wrench, given at the TCP in the base's axes, at the flange.

        The result is in the flange's axes [N, N·m].
        """
        import numpy as np

        R = self.flange(positions)[:3, :3]
        force, torque = R.T @ np.asarray(wrench[:3]), R.T @ np.asarray(wrench[3:])
        torque = torque + np.cross(np.asarray(tcp[:3]), force)
        fx, fy, fz = map(float, force)
        tx, ty, tz = map(float, torque)
        return fx, fy, fz, tx, ty, tz
