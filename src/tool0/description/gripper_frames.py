"""The frame between the pads of a gripper for many joint positions at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from tool0.description.grasp_frames import flange_of, frame_between, pad_links
from tool0.description.joint_tree import LinkFrames
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.transform_arrays import Array, Frames


@final
class GripperFrames:
    """The frame midway between the pads of one gripper, for n sets of positions.

    As in ``Gripper.tcp``, the y axis points from one pad to the other, and the z axis
    points away from the gripper.
    """

    def __init__(self, model: RobotModel, gripper: ParallelGripper) -> None:
        """Find the pads; raise ControlError unless there are two pads."""
        self._gripper = gripper
        base = model.joint(gripper.joint).parent
        self._flange = flange_of(model, gripper)
        self._carrier = LinkFrames(model, [self._flange])
        self._links = (base, *pad_links(model, gripper))
        self._fingers = LinkFrames(model, [self._flange, *self._links])

    def poses(self, position: Mapping[str, Array], n: int) -> Frames:
        """Return the frame in the root frame, at measured joint positions (n,)."""
        q = position[self._gripper.joint]
        # The fingers are assumed to follow their drive exactly, as in ``Gripper.tcp``.
        fingers = {self._gripper.joint: self._within_range(q)}
        poses = self._fingers.poses(fingers, n)
        to_carrier = poses[self._flange].inverse()
        base, first, second = (
            (to_carrier @ poses[link]).position for link in self._links
        )
        in_flange = Frames(*frame_between(base, first, second))
        carrier = self._carrier.poses(position, n)[self._flange]
        return carrier @ in_flange

    def _within_range(self, position: Array) -> Array:
        """Return joint positions [rad | m], clamped to the range of the openings."""
        gripper = self._gripper
        closed, opened = gripper.position(0.0), gripper.position(gripper.max_opening)
        return position.clip(min(closed, opened), max(closed, opened))
