"""Forward kinematics of a single posture of an arm, computed with Python floats.

``ArmChain.forward`` is efficient for many postures. For a single posture,
``ArmChain.forward`` would spend most of its time on numpy's overhead.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np

from tool0.description.flat_frames import FlatTree, Frame
from tool0.description.transform import Transform, Vector3, from_arrays
from tool0.kinematics.chain import ArmChain, Array


class ScalarPosture(NamedTuple):
    """Joints and flange of an arm at one posture, relative to a fixed frame."""

    flange: Transform
    axes: tuple[Vector3, ...]
    """Joint axes as unit vectors."""
    points: tuple[Vector3, ...]
    """One point on each joint axis [m]."""

    def velocity(
        self, point: Vector3, qd: Sequence[float], n_joints: int = 6
    ) -> tuple[Vector3, Vector3]:
        """Return the linear velocity of a point and the angular velocity [m/s, rad/s].

        The velocities are those of the link after the first ``n_joints`` joints. The
        point is given in the fixed frame.
        """
        x, y, z = point
        vx = vy = vz = wx = wy = wz = 0.0
        rows = zip(self.axes[:n_joints], self.points, qd, strict=False)
        for (ax, ay, az), (px, py, pz), speed in rows:
            ax, ay, az = speed * ax, speed * ay, speed * az  # noqa: PLW2901
            rx, ry, rz = x - px, y - py, z - pz
            vx += ay * rz - az * ry
            vy += az * rx - ax * rz
            vz += ax * ry - ay * rx
            wx += ax
            wy += ay
            wz += az
        return (vx, vy, vz), (wx, wy, wz)

    def efforts(self, force: Vector3, torque: Vector3) -> tuple[float, ...]:
        """Return the joint torques that a wrench on the flange causes [N·m].

        The wrench acts at the flange's origin. The components of the wrench are in the
        axes of the fixed frame.
        """
        fx, fy, fz = force
        tx, ty, tz = torque
        x, y, z = self.flange.position
        found = []
        for (ax, ay, az), (px, py, pz) in zip(self.axes, self.points, strict=True):
            rx, ry, rz = x - px, y - py, z - pz
            found.append(
                ax * (tx + ry * fz - rz * fy)
                + ay * (ty + rz * fx - rx * fz)
                + az * (tz + rx * fy - ry * fx)
            )
        return tuple(found)


@final
class ScalarChain:
    """An arm's joints, relative to a fixed frame, and its flange."""

    def __init__(self, chain: ArmChain, T_base_chain: Array) -> None:
        """Use the joints of ``chain``; results are in the fixed frame *base*.

        ``T_base_chain`` is the pose of the chain's base link in *base*, shape (4, 4).
        """
        first, *others = chain.tree
        first = first._replace(placement=T_base_chain @ first.placement)
        self._tree = FlatTree([first, *others])
        back = from_arrays(np.zeros(3), self._tree.turns[-1].T)
        self._T_turned_tip = back @ chain.T_last_tip

    def forward(self, q: Sequence[float]) -> ScalarPosture:
        """Return the posture at joint positions ``q`` [rad]."""
        frames = self._tree.frames(q)
        return ScalarPosture(
            flange=_transform(frames[-1]) @ self._T_turned_tip,
            axes=tuple((frame[6], frame[7], frame[8]) for frame in frames),
            points=tuple((frame[9], frame[10], frame[11]) for frame in frames),
        )


def _transform(frame: Frame) -> Transform:
    ax, ay, az, bx, by, bz, cx, cy, cz, x, y, z = frame
    return Transform(
        position=(x, y, z), rotation=((ax, bx, cx), (ay, by, cy), (az, bz, cz))
    )
