"""Poses of flanges and tool center points (TCPs) for many joint positions at once."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import Final, final

import numpy as np

from tool0.description.gripper_frames import GripperFrames
from tool0.description.joint_tree import LinkFrames
from tool0.description.model import RobotModel
from tool0.description.parts import find_grippers, flange_names
from tool0.description.transform_arrays import Array
from tool0.errors import ControlError

POSE: Final = ("x", "y", "z", "qw", "qx", "qy", "qz")
"""Numbers of a pose in tables: the position [m] and a unit quaternion."""


@final
class ToolPoses:
    """The flanges of a robot and the TCPs of its grippers, by name.

    A flange has the name of its link, such as ``tool0`` or ``left_tool0``.  A TCP, the
    point midway between the pads of a gripper, is named after the gripper, such as
    ``gripper.tcp``.  A gripper without two pads has no TCP.
    """

    def __init__(self, model: RobotModel, joint_names: Sequence[str]) -> None:
        """Use joint positions in the order of ``joint_names``."""
        self._joint_names = tuple(joint_names)
        self._flanges = tuple(flange_names(model).values())
        self._links = LinkFrames(model, self._flanges)
        self._tcps: dict[str, GripperFrames] = {}
        for name, gripper in find_grippers(model).items():
            with contextlib.suppress(ControlError):  # the gripper has no two pads
                self._tcps[f"{name}.tcp"] = GripperFrames(model, gripper)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the flanges, then of the TCPs."""
        return (*self._flanges, *self._tcps)

    def poses(self, position: Array) -> dict[str, Array]:
        """Return ``POSE`` of each flange and TCP in the root frame, shape (n, 7).

        Consecutive quaternions have the sign that makes their difference small.

        Args:
            position: Joint positions [rad | m], shape (n, n_joints).
        """
        n = len(position)
        joints = dict(zip(self._joint_names, position.T, strict=True))
        links = self._links.poses(joints, n)
        found = {flange: links[flange] for flange in self._flanges}
        for name, tcp in self._tcps.items():
            found[name] = tcp.poses(joints, n)
        return {
            name: np.hstack([frames.position, _continuous(frames.quat_wxyz)])
            for name, frames in found.items()
        }


def _continuous(quat: Array) -> Array:
    """Return quaternions, (n, 4), with signs that make consecutive ones similar."""
    turns = np.where((quat[1:] * quat[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    signs = np.concatenate([np.ones(min(len(quat), 1)), np.cumprod(turns)])
    return np.asarray(quat * signs[:, None])
