"""Arms and grippers of the copies: poses, openings and inverse kinematics."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TypeVar, final

import numpy as np
from numpy.typing import ArrayLike

from tool0.batch.arguments import Arguments, Which
from tool0.batch.state import State
from tool0.description.gripper_frames import GripperFrames
from tool0.description.joint_tree import LinkFrames
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.parts import find_arms, find_grippers
from tool0.description.transform_arrays import Frames, from_quats
from tool0.errors import ControlError, did_you_mean
from tool0.kinematics.chain import ArmChain, Array, find_chains
from tool0.kinematics.inverse import InverseKinematics
from tool0.kinematics.only_part import only_part

Item = TypeVar("Item")


@final
class Kinematics:
    """Kinematics of the arms and grippers at the joint positions of all copies.

    ``robot`` is the name of an arm; ``robot`` and ``gripper`` may be None if there is
    only one such part.
    """

    def __init__(self, model: RobotModel, state: State) -> None:
        """Compute with the joint positions in ``state``."""
        self._model = model
        self._state = state
        self._link_frames: dict[str, LinkFrames] = {}
        """Chains from the root to a link, cached by link."""
        self._gripper_frames: dict[str, GripperFrames] = {}
        """Frames between the pads, cached by gripper."""
        self._inverses: dict[str, InverseKinematics] = {}
        """Inverse kinematics of arms, cached by the last link of the arm."""

    @cached_property
    def grippers(self) -> Mapping[str, ParallelGripper]:
        """The grippers by name."""
        return find_grippers(self._model)

    def gripper(self, name: str | None) -> ParallelGripper:
        """Return a gripper, or raise ControlError if there is no such gripper."""
        return self._part(self.grippers, name, "gripper")

    def flange(self, robot: str | None) -> str:
        """Return the tool0 link of an arm.

        Raises:
            ControlError: If there is no such arm.
        """
        return self._part(find_arms(self._model), robot, "arm").flange

    def tool_pose(self, robot: str | None) -> Frames:
        """Return the frame of tool0 in the root frame; see ``Batch.tool_pose``."""
        return self._link_pose(self.flange(robot))

    def tcp_pose(self, gripper: str | None) -> Frames:
        """Return the frame of the TCP in the root frame; see ``Batch.tcp_pose``."""
        geometry = self.gripper(gripper)
        if geometry.name not in self._gripper_frames:
            frames = GripperFrames(self._model, geometry)
            self._gripper_frames[geometry.name] = frames
        frames = self._gripper_frames[geometry.name]
        return frames.poses(self._positions(), self._state.n)

    def opening(self, gripper: str | None) -> Array:
        """Return the distance between the pads [m], shape (n,)."""
        geometry = self.gripper(gripper)
        position, _, _ = self._state.joints()
        q = position[:, self._state.joint_names.index(geometry.joint)].tolist()
        return np.array([max(0.0, geometry.opening(value)) for value in q])

    def inverse(
        self,
        position: ArrayLike,
        quat: ArrayLike,
        robot: str | None,
        which: Which | None,
    ) -> Array:
        """Return joint positions for poses; see ``Batch.inverse_kinematics``."""
        n = self._state.n
        check = Arguments(n, "inverse_kinematics")
        rows = check.which(which)
        p = check.rows("position", position, (3,), rows)
        orientation = check.rows("quat", quat, (4,), rows, " for w, x, y, z")
        if not np.linalg.norm(orientation[rows], axis=1).all():
            raise ControlError("Batch.inverse_kinematics: 'quat' has a zero row")
        chain = self._part(self._chains, robot, "arm")
        if chain.tip not in self._inverses:
            self._inverses[chain.tip] = InverseKinematics(chain)
        joints = [self._state.joint_names.index(name) for name in chain.joint_names]
        base = self._link_pose(chain.base)
        target = Frames(p[rows], from_quats(orientation[rows]))
        here = Frames(base.position[rows], base.rotation[rows])
        T_base_tip = (here.inverse() @ target).matrices
        found = np.full((n, len(joints)), np.nan)
        measured, _, _ = self._state.joints()
        near = measured[rows][:, joints]
        found[rows] = self._inverses[chain.tip].nearest(T_base_tip, near)
        return found

    @cached_property
    def _chains(self) -> Mapping[str, ArmChain]:
        return find_chains(self._model)

    def _link_pose(self, link: str) -> Frames:
        """Return the frame of a link in the root frame."""
        if link not in self._link_frames:
            self._link_frames[link] = LinkFrames(self._model, [link])
        frames = self._link_frames[link]
        return frames.poses(self._positions(), self._state.n)[link]

    def _positions(self) -> dict[str, Array]:
        """Return the positions of each joint [rad | m], shape (n,)."""
        position, _, _ = self._state.joints()
        return dict(zip(self._state.joint_names, position.T, strict=True))

    def _part(self, parts: Mapping[str, Item], name: str | None, kind: str) -> Item:
        """Return a part by name, or the only part if ``name`` is None."""
        if name is None:
            return only_part(parts, kind, self._model)
        if name not in parts:
            raise ControlError(f"no {kind} '{name}'{did_you_mean(name, set(parts))}")
        return parts[name]
