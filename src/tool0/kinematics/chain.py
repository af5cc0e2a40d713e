"""Forward kinematics of a six-joint arm, vectorized over postures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.description.joint_tree import JointTree, place_links
from tool0.description.model import FLANGE, Joint, JointLimits, RobotModel
from tool0.description.parts import ARM_JOINTS, find_arms
from tool0.description.transform import Transform, to_transform
from tool0.errors import ControlError

Array = NDArray[np.float64]


class Posture(NamedTuple):
    """Kinematics of n postures in the frame of the arm's base link."""

    T_base_tip: Array
    """Poses of the tip, shape (n, 4, 4)."""
    axes: Array
    """Joint axes as unit vectors, shape (n, 6, 3)."""
    points: Array
    """One point on each joint axis [m], shape (n, 6, 3)."""

    @property
    def jacobian(self) -> Array:
        """Jacobian of the tip with linear rows above angular rows, shape (n, 6, 6)."""
        return self.jacobian_at(self.T_base_tip[:, :3, 3])

    def jacobian_at(self, point: Array) -> Array:
        """Return the Jacobian of a ``point`` on the tip in base axes [m], (n, 3)."""
        x, y, z = self.axes.transpose(2, 0, 1)
        rx, ry, rz = (point[:, None] - self.points).transpose(2, 0, 1)
        columns = np.empty((len(point), ARM_JOINTS, 6))
        columns[..., 0] = y * rz - z * ry
        columns[..., 1] = z * rx - x * rz
        columns[..., 2] = x * ry - y * rx
        columns[..., 3:] = self.axes
        return columns.swapaxes(1, 2)


@final
class ArmChain:
    """The six revolute joints from an arm's base link to its flange."""

    def __init__(self, model: RobotModel, tip: str, joints: Sequence[Joint]) -> None:
        """Use six joints, ordered from base to tip, and the link ``tip`` at the end."""
        self.joints = tuple(joints)
        self.joint_names = tuple(joint.name for joint in joints)
        self.base = joints[0].parent
        """The link on which the arm is mounted."""
        self.tip = tip
        self._model = model
        placed = place_links(model, [tip], self.base)
        self.tree = placed.tree
        """The joints in the frame of ``base``."""
        self.T_last_tip: Transform = placed.placements[tip][1]
        """Pose of the tip in the frame of the last joint."""
        self._forward = JointTree(self.tree)
        self._last = self.T_last_tip.matrix

    def with_joints(self, joints: Sequence[Joint]) -> ArmChain:
        """Return the same arm with the limits of the given joints."""
        return ArmChain(self._model, self.tip, joints)

    def forward(self, q: Array) -> Posture:
        """Return the kinematics at joint positions ``q`` [rad], shape (n, 6)."""
        rotations, points, axes = self._forward.forward(q)
        T = np.zeros((len(q), 4, 4))
        T[:, :3, :3] = rotations[-1] @ self._last[:3, :3]
        T[:, :3, 3] = points[:, -1] + rotations[-1] @ self._last[:3, 3]
        T[:, 3, 3] = 1.0
        return Posture(T, axes, points)


def find_chains(
    model: RobotModel, limits: Mapping[str, JointLimits] | None = None
) -> dict[str, ArmChain]:
    """Return the arms of a robot by name.

    ``limits``, given by joint name, override the URDF's limits, because the
    controllers' YAML file may contain other limits.
    """
    own = limits or {}

    def limited(joint: Joint) -> Joint:
        return replace(joint, limits=own.get(joint.name, joint.limits))

    return {
        name: ArmChain(model, arm.flange, tuple(map(limited, arm.joints)))
        for name, arm in find_arms(model).items()
    }


def why_no_arm(model: RobotModel) -> str:
    """Return the reason why a robot has no arm."""
    if not model.flanges:
        return f"no link is called {FLANGE}, with or without a prefix"
    return f"above '{model.flanges[0]}' are not {ARM_JOINTS} turning joints in a row"


def fixed_transform(model: RobotModel, first: str, second: str) -> Transform:
    """Return the pose of link ``second`` in the frame of link ``first``.

    The links must be fixed to each other.

    Raises:
        ModelError: If the robot does not have one of the links.
        ControlError: If there is a movable joint between the links.
    """
    root_first, T_root_first = _rigid_root(model, first)
    root_second, T_root_second = _rigid_root(model, second)
    if root_first != root_second:
        raise ControlError(
            f"link '{second}' is not fixed to '{first}': a joint that moves is between "
            "them"
        )
    return T_root_first.inverse() @ T_root_second


def _rigid_root(model: RobotModel, link: str) -> tuple[str, Transform]:
    """Return the topmost link to which ``link`` is fixed, and the pose of ``link``."""
    name = model.link(link).name
    pose = Transform()
    while (joint := model.parent_joint.get(name)) and not joint.is_movable:
        pose = to_transform(joint.origin) @ pose
        name = joint.parent
    return name, pose
