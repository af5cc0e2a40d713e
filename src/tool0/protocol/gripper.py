"""Parallel grippers in terms of the opening between their pads: state and requests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, final

from msgspec import Meta

from tool0.protocol.goals import GoalStarted
from tool0.protocol.request import Name, Request

GripperMotion = Literal[
    "moving", "at_target", "holding_inside", "holding_outside", "blocked", "idle"
]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GraspState:
    """Motion of a gripper, and its opening."""

    motion: GripperMotion
    """``holding_inside``: squeezes an object between the pads.  ``holding_outside``:
    presses the pads outwards against an object.  ``blocked``: cannot move on although
    nothing presses on both fingers.  ``idle``: no position controller is running."""
    opening: float
    """Distance between the pads [m]."""
    width: float | None = None
    """Width of the object between the pads [m]; None if fingers wrap around it."""

    @property
    def gobj(self) -> int:
        """Value of Robotiq's register gOBJ.

        0: moving, idle or blocked; 1: stopped by an object while opening; 2: stopped by
        an object while closing; 3: arrived.  (A real gripper mistakes blocked fingers
        for an object.)
        """
        return _GOBJ[self.motion]


_GOBJ: dict[GripperMotion, int] = {
    "moving": 0,
    "idle": 0,
    "blocked": 0,
    "holding_outside": 1,
    "holding_inside": 2,
    "at_target": 3,
}


class Grip(Request[GoalStarted], frozen=True):
    """Move the pads of a gripper to an opening."""

    gripper: Name | None = None
    """Name of the gripper; may be left out if the robot has only one."""
    opening: float | None = None
    """Distance between the pads [m], 0 … the gripper's maximum."""
    position: float | None = None
    """Position of the driven joint [rad | m], instead of an opening."""
    speed: float | None = None
    """Speed of the pads relative to each other [m/s]; the gripper's maximum if left
    out."""
    force: float | None = None
    """Largest force at each pad [N]; the gripper's maximum if left out."""
    effort: Annotated[float, Meta(gt=0.0)] | None = None
    """Largest effort of the driven joint [N·m | N], instead of a force."""


class ReactivateGripper(Request[GoalStarted], frozen=True):
    """Reactivate a gripper like ROS 2's service: it opens, even if it holds an object.

    A real gripper also closes and opens once more.
    """

    controller: Name
    """Name of a running RobotiqActivationController with the gripper's prefix."""


class ReadGripper(Request[GraspState], frozen=True):
    """Read a gripper's state: whether it moves, has arrived, or holds an object."""

    gripper: Name | None = None
    """Name of the gripper; may be left out if the robot has only one."""
