"""Parallel grippers, by the opening between their pads: state and requests."""

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
    """``holding_inside`` squeezes an object between the pads, ``holding_outside``
    presses them outwards against one; ``blocked`` cannot move on, without anything that
    presses on both fingers; ``idle`` without a position controller."""
    opening: float
    """Distance between the pads [m]."""
    width: float | None = None
    """Width of the object between the pads [m]; None where fingers wrap around it."""

    @property
    def gobj(self) -> int:
        """Robotiq's register.

        0 moving, idle or blocked, 1 stopped by an object while opening, 2 the same
        while closing, 3 arrived.  (A real gripper takes blocked fingers for an object.)
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
    """The robot's only one, if left out."""
    opening: float | None = None
    """Distance between the pads [m], 0 … the gripper's maximum."""
    position: float | None = None
    """Instead of an opening: position of the driven joint [rad | m]."""
    speed: float | None = None
    """Speed of the pads relative to each other [m/s]; the fastest, if left out."""
    force: float | None = None
    """Largest force at each pad [N]; the strongest, if left out."""
    effort: Annotated[float, Meta(gt=0.0)] | None = None
    """Instead of a force: largest effort of the driven joint [N·m | N]."""


class ReactivateGripper(Request[GoalStarted], frozen=True):
    """Activate a gripper again, as ROS 2's service does: it opens, whatever it holds.

    A real one closes and opens once more.
    """

    controller: Name
    """A running RobotiqActivationController; it and its gripper have one prefix."""


class ReadGripper(Request[GraspState], frozen=True):
    """The state of a gripper: whether it moves, has arrived, or holds an object."""

    gripper: Name | None = None
    """The robot's only one, if left out."""
