"""The six joints of an arm and its forward kinematics, vectorized over postures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.description.model import FLANGE, Joint, JointLimits, RobotModel
from tool0.description.parts import ARM_JOINTS, find_arms
from tool0.description.transform import Transform, to_transform
from tool0.errors import ControlError

Array = NDArray[np.float64]


class Posture(NamedTuple):
    """Kinematics of n joint configurations, in the link that carries the arm."""

    T_base_tip: Array
    """Shape (n, 4, 4)."""
    axes: Array
    """The joints' axes, unit vectors, shape (n, 6, 3)."""
    points: Array
    """A point on each axis [m], shape (n, 6, 3)."""

    @property
    def jacobian(self) -> Array:
        """V_base_tip per joint velocity, linear above angular, shape (n, 6, 6)."""
        lever = self.T_base_tip[:, None, :3, 3] - self.points
        columns = np.concatenate([np.cross(self.axes, lever), self.axes], axis=2)
        return columns.swapaxes(1, 2)


@final
class ArmChain:
    """Six turning joints from the link that carries an arm to its flange."""

    def __init__(self, model: RobotModel, tip: str, joints: Sequence[Joint]) -> None:
        """Take the six joints, from base to tip, and the link ``tip`` at the end."""
        self.joints = tuple(joints)
        self.joint_names = tuple(joint.name for joint in joints)
        self.base = joints[0].parent
        """The link that carries the arm."""
        self.tip = tip
        steps = []
        link = self.base
        for joint in self.joints:
            step = fixed_transform(model, link, joint.parent)
            steps.append((step @ to_transform(joint.origin)).matrix)
            link = joint.child
        self._steps = np.array(steps)
        self._last = fixed_transform(model, link, tip).matrix
        self._axes = np.array([joint.axis for joint in joints])
        self._crosses = np.array([cross_matrix(*axis) for axis in self._axes])
        self._squares = self._crosses @ self._crosses

    @property
    def fixed_parts(self) -> tuple[Array, Array, Array]:
        """What does not turn.

        The pose of each joint in the link before it, shape (6, 4, 4), of the tip in the
        last link, shape (4, 4), and the axes in the joints' frames, shape (6, 3).
        """
        return self._steps, self._last, self._axes

    def forward(self, q: Array) -> Posture:
        """Return the pose of the flange at positions ``q`` [rad], shape (n, 6)."""
        turns = rodrigues(self._crosses, self._squares, q)
        axes = np.empty((len(q), ARM_JOINTS, 3))
        points = np.empty_like(axes)
        R = np.broadcast_to(np.eye(3), (len(q), 3, 3))
        p = np.zeros((len(q), 3))
        for k, step in enumerate(self._steps):
            p = p + R @ step[:3, 3]
            R = R @ step[:3, :3]
            points[:, k] = p
            axes[:, k] = R @ self._axes[k]
            R = R @ turns[:, k]
        T = np.zeros((len(q), 4, 4))
        T[:, :3, :3] = R @ self._last[:3, :3]
        T[:, :3, 3] = p + R @ self._last[:3, 3]
        T[:, 3, 3] = 1.0
        return Posture(T, axes, points)


def cross_matrix(x: float, y: float, z: float) -> Array:
    """Return the matrix K of a vector, such that K @ v is its cross product with v."""
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rodrigues(K: Array, K_squared: Array, angle: Array) -> Array:
    """Return rotations by ``angle`` [rad], shape (…), about unit axes.

    Rodrigues' formula with the axes' cross-product matrices ``K``, of shape (3, 3) or
    that of the result, (…, 3, 3).
    """
    sin, versine = np.sin(angle), 1.0 - np.cos(angle)
    turn = sin[..., None, None] * K
    return np.asarray(np.eye(3) + turn + versine[..., None, None] * K_squared)


def find_chains(
    model: RobotModel, limits: Mapping[str, JointLimits] | None = None
) -> dict[str, ArmChain]:
    """Return the arms of a robot by name.

    ``limits``, by joint, replace those of the URDF: the controllers' YAML may have
    others.
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
    """Return the pose of link ``second`` in ``first``, which are fixed to each other.

    Raises:
        ModelError: If the robot lacks one of them.
        ControlError: If a joint that moves is between them.
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
    """Return the first of the links that are fixed to ``link``, and its pose there."""
    name = model.link(link).name
    pose = Transform()
    while (joint := model.parent_joint.get(name)) and not joint.is_movable:
        pose = to_transform(joint.origin) @ pose
        name = joint.parent
    return name, pose
