"""Poses of links in many copies of a robot at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, final

import numpy as np

from tool0.description.model import Joint, JointType, ParallelGripper, RobotModel
from tool0.description.transform import to_transform
from tool0.kinematics.chain import Array, cross_matrix, rodrigues
from tool0.sensing.grasp import flange_of, pad_links


class Frames(NamedTuple):
    """Rigid transforms, one per copy."""

    position: Array
    """[m], shape (n, 3)."""
    rotation: Array
    """Rotation matrices, shape (n, 3, 3)."""

    def __matmul__(self, other: Frames) -> Frames:
        """Return the poses of ``other``, given in these frames, in their parents."""
        position = self.position + _turned(self.rotation, other.position)
        return Frames(position, self.rotation @ other.rotation)

    def inverse(self) -> Frames:
        """Return the inverse transforms."""
        transposed = self.rotation.swapaxes(-1, -2)
        return Frames(-_turned(transposed, self.position), transposed)

    @property
    def quat_wxyz(self) -> Array:
        """The rotations as unit quaternions with w >= 0, shape (n, 4)."""
        R = self.rotation
        xx, yy, zz = R[:, 0, 0], R[:, 1, 1], R[:, 2, 2]
        # Products of the quaternion's parts; the row of the largest one is exact.
        table = np.empty((len(R), 4, 4))
        table[:, 0, 0] = 1 + xx + yy + zz
        table[:, 1, 1] = 1 + xx - yy - zz
        table[:, 2, 2] = 1 - xx + yy - zz
        table[:, 3, 3] = 1 - xx - yy + zz
        for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
            a, b = j - 1, k - 1
            table[:, 0, i] = table[:, i, 0] = R[:, b, a] - R[:, a, b]
            table[:, j, k] = table[:, k, j] = R[:, b, a] + R[:, a, b]
        largest = table[:, range(4), range(4)].argmax(axis=1)
        quat = table[np.arange(len(R)), largest]
        quat /= np.linalg.norm(quat, axis=1, keepdims=True)
        return np.asarray(np.where(quat[:, :1] < 0.0, -quat, quat))


@final
class LinkFrames:
    """Forward kinematics from the root to one link, for n copies."""

    def __init__(self, model: RobotModel, link: str) -> None:
        """Collect the joints above ``link``; ModelError if there is no such link."""
        joints: list[Joint] = []
        name = model.link(link).name
        while (joint := model.parent_joint.get(name)) is not None:
            joints.append(joint)
            name = joint.parent
        self._steps = [_Step(joint) for joint in reversed(joints)]

    def poses(self, position: Mapping[str, Array]) -> Frames:
        """Return the link's pose in the root, by positions [rad | m] of shape (n,).

        A joint without a position follows the one that it mimics.
        """
        n = len(next(iter(position.values())))
        found = Frames(np.zeros((n, 3)), np.broadcast_to(np.eye(3), (n, 3, 3)))
        for step in self._steps:
            found = step.applied(found, position)
        return found


@final
class _Step:
    """One joint: its origin, and its motion."""

    def __init__(self, joint: Joint) -> None:
        origin = to_transform(joint.origin).matrix
        self._joint = joint
        self._translation, self._rotation = origin[:3, 3], origin[:3, :3]
        self._axis = np.array(joint.axis)
        self._cross = cross_matrix(*joint.axis)
        self._square = self._cross @ self._cross

    def applied(self, frames: Frames, position: Mapping[str, Array]) -> Frames:
        p = frames.position + frames.rotation @ self._translation
        R = frames.rotation @ self._rotation
        joint = self._joint
        if joint.is_movable:
            q = joint_position(joint, position)
            if joint.type is JointType.PRISMATIC:
                p = p + (R @ self._axis) * q[:, None]
            elif joint.type in {JointType.REVOLUTE, JointType.CONTINUOUS}:
                R = R @ rodrigues(self._cross, self._square, q)
        return Frames(p, R)


@final
class GripperFrames:
    """The frame midway between the pads of one gripper, for n copies.

    As ``Gripper.tcp``: y points from pad to pad, z away from the gripper.
    """

    def __init__(self, model: RobotModel, gripper: ParallelGripper) -> None:
        """Find the pads; ControlError if there are not two of them."""
        self._gripper = gripper
        base = model.joint(gripper.joint).parent
        self._carrier = LinkFrames(model, flange_of(model, gripper))
        self._links = [
            LinkFrames(model, link) for link in (base, *pad_links(model, gripper))
        ]

    def poses(self, position: Mapping[str, Array]) -> Frames:
        """Return the frame in the root, by measured positions of shape (n,)."""
        q = position[self._gripper.joint]
        # The fingers follow their drive here, as they do in ``Gripper.tcp``.
        fingers = {self._gripper.joint: self._within_range(q)}
        to_carrier = self._carrier.poses(fingers).inverse()
        base, first, second = (to_carrier @ link.poses(fingers) for link in self._links)
        middle = (first.position + second.position) / 2.0
        y = _unit(second.position - first.position)
        away = middle - base.position
        z = _unit(away - (away * y).sum(axis=1, keepdims=True) * y)
        rotation = np.stack([np.cross(y, z), y, z], axis=2)
        return self._carrier.poses(position) @ Frames(middle, rotation)

    def _within_range(self, position: Array) -> Array:
        """Return the positions [rad | m] of openings within the gripper's range."""
        gripper = self._gripper
        closed, opened = gripper.position(0.0), gripper.position(gripper.max_opening)
        return position.clip(min(closed, opened), max(closed, opened))


def joint_position(joint: Joint, position: Mapping[str, Array]) -> Array:
    """Return a joint's positions, shape (n,): as given, by its mimic relation, or 0."""
    if joint.name in position:
        return position[joint.name]
    zero = np.zeros(len(next(iter(position.values()))))
    if joint.mimic is None:
        return zero
    master = position.get(joint.mimic.joint, zero)
    return joint.mimic.multiplier * master + joint.mimic.offset


def _turned(rotation: Array, vectors: Array) -> Array:
    return np.asarray((rotation @ vectors[..., None])[..., 0])


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
