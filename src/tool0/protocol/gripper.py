"""Parallel grippers: their state, and requests with the opening between the pads."""

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
    """Motion and opening of a gripper."""

    motion: GripperMotion
    """``holding_inside``: the gripper squeezes an object between the pads.
    ``holding_outside``: the gripper presses the pads outward against an object.
    ``blocked``: the gripper cannot move further, but does not hold an object.
    ``idle``: no position controller is running."""
    opening: float
    """Distance between the pads [m]."""
    width: float | None = None
    """Width of the object between the pads [m]; None if the fingers wrap around the
    object."""

    @property
    def gobj(self) -> int:
        """Value of Robotiq's register gOBJ.

        0: moving, idle or blocked; 1: stopped by an object while opening; 2: stopped by
            an object while closing; 3: at the target.  (A real gripper reports blocked
            fingers as an object.)
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
    """Name of the gripper; required only if the robot has several grippers."""
    opening: float | None = None
    """Distance between the pads [m], from 0 to the gripper's maximum."""
    position: float | None = None
    """Position of the driven joint [rad | m], instead of an opening."""
    speed: float | None = None
    """Speed of the pads relative to each other [m/s]; the default is the gripper's
    maximum."""
    force: float | None = None
    """Maximum force at each pad [N]; the default is the gripper's maximum."""
    effort: Annotated[float, Meta(gt=0.0)] | None = None
    """Maximum effort of the driven joint [N·m | N], instead of a force."""


class ReactivateGripper(Request[GoalStarted], frozen=True):
    """Reactivate a gripper, as the ROS 2 service does.

    The gripper opens, even if it holds an object.

    A real gripper also closes and opens again.
    """

    controller: Name
    """Name of a running RobotiqActivationController with the gripper's prefix."""


class ReadGripper(Request[GraspState], frozen=True):
    """Read a gripper's state: whether it moves, is at the target or holds an object."""

    gripper: Name | None = None
    """Name of the gripper; required only if the robot has several grippers."""
