"""Forward kinematics of the moving joints for many joint positions.

Fixed joints are merged into the placements of the moving joints.
``forward_kinematics`` computes the kinematics of a single posture, given by joint name,
and ``flat_frames`` is used in the tick.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, final

import numpy as np

from tool0.description.forward_kinematics import TURNING, joint_position
from tool0.description.model import Joint, JointType, RobotModel
from tool0.description.transform import Transform, Vector3, to_transform
from tool0.description.transform_arrays import (
    Array,
    Frames,
    cross_matrices,
    rotations_about,
)


class TreeJoint(NamedTuple):
    """A revolute, continuous or prismatic joint."""

    parent: int
    """Index of the joint that carries this joint; -1 denotes the root."""
    placement: Array
    """Frame of the joint at position 0 in the parent joint's frame, shape (4, 4)."""
    axis: Vector3
    is_prismatic: bool


class JointFrames(NamedTuple):
    """Frames of m joints in the root at n positions, including the joints' motions."""

    rotations: list[Array]
    """Rotation matrices of the frames: m arrays of shape (n, 3, 3)."""
    origins: Array
    """Origins of the frames [m], shape (n, m, 3)."""
    axes: Array
    """Unit vectors along the joints' axes in the root, shape (n, m, 3)."""


@final
class JointTree:
    """Tree of joints; each joint is placed relative to an earlier joint or the root."""

    def __init__(self, joints: Sequence[TreeJoint]) -> None:
        self._joints = tuple(joints)
        axes = np.array([joint.axis for joint in joints]).reshape(-1, 3)
        self._axes = axes
        self._crosses = cross_matrices(axes)
        self._squares = self._crosses @ self._crosses

    def forward(self, q: Array) -> JointFrames:
        """Return the joints' frames at positions ``q`` [rad | m], shape (n, m)."""
        turns = rotations_about(self._crosses, self._squares, q)
        n, m = q.shape
        rotations: list[Array] = []
        origins, axes = np.empty((n, m, 3)), np.empty((n, m, 3))
        for k, (parent, T, _, is_prismatic) in enumerate(self._joints):
            R, p = T[:3, :3], T[:3, 3]
            if parent >= 0:
                carrier = rotations[parent]
                R, p = carrier @ R, origins[:, parent] + carrier @ p
            axes[:, k] = axis = R @ self._axes[k]
            if is_prismatic:
                p = p + q[:, k, None] * axis
                R = np.broadcast_to(R, (n, 3, 3))
            else:
                R = R @ turns[:, k]
            origins[:, k] = p
            rotations.append(R)
        return JointFrames(rotations, origins, axes)


class PlacedLinks(NamedTuple):
    """Links, and the moving joint that carries each link."""

    joints: tuple[Joint, ...]
    """Revolute, continuous and prismatic joints.  A parent precedes its children."""
    tree: tuple[TreeJoint, ...]
    """The elements of ``joints``, in the form used by ``JointTree``."""
    placements: dict[str, tuple[int, Transform]]
    """Map from a link to two values: the index of the joint that carries the link (-1
    if no joint does), and the link's pose in that joint's frame."""


def place_links(
    model: RobotModel, links: Iterable[str], root: str | None = None
) -> PlacedLinks:
    """Return ``links`` and all links above them up to ``root``.

    Raises:
        ModelError: If the robot does not have one of the links.
    """
    above: set[str] = set()
    first = model.root if root is None else root
    for link in links:
        name = model.link(link).name
        while name != first and (joint := model.parent_joint.get(name)):
            above.add(joint.name)
            name = joint.parent
    joints: list[Joint] = []
    tree: list[TreeJoint] = []
    placed = {first: (-1, Transform())}
    for joint in model.joints:
        if joint.name not in above:
            continue
        parent, pose = placed[joint.parent]
        pose = pose @ to_transform(joint.origin)
        is_prismatic = joint.type is JointType.PRISMATIC
        if is_prismatic or joint.type in TURNING:
            tree.append(TreeJoint(parent, pose.matrix, joint.axis, is_prismatic))
            joints.append(joint)
            parent, pose = len(tree) - 1, Transform()
        placed[joint.child] = (parent, pose)
    return PlacedLinks(tuple(joints), tuple(tree), placed)


@final
class LinkFrames:
    """Poses of some links in the root of a model, for n joint positions."""

    def __init__(self, model: RobotModel, links: Sequence[str]) -> None:
        """Collect the joints above ``links``, or raise ModelError for unknown links."""
        self._links = tuple(links)
        self._joints, tree, self._placements = place_links(model, links)
        self._tree = JointTree(tree)

    def poses(self, position: Mapping[str, Array], n: int) -> dict[str, Frames]:
        """Return the links' poses for joint positions [rad | m], each of shape (n,).

        A joint without a given position is at 0, or follows its master joint.
        """
        q = np.empty((n, len(self._joints)))
        for k, joint in enumerate(self._joints):
            q[:, k] = joint_position(joint, position)
        rotations, origins, _ = self._tree.forward(q)
        root = Frames(np.zeros((n, 3)), np.broadcast_to(np.eye(3), (n, 3, 3)))
        found = {}
        for link in self._links:
            k, pose = self._placements[link]
            carrier = root if k < 0 else Frames(origins[:, k], rotations[k])
            found[link] = carrier @ pose
        return found
