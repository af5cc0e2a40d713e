"""Requests that move joints and grippers."""

from __future__ import annotations

from typing import Annotated, Any

from msgspec import Meta, Struct, structs

from tool0.protocol.goals import GoalStarted
from tool0.protocol.request import (
    CollisionRule,
    JointPositions,
    Name,
    Request,
    SpeedScale,
)


class GripLimits(Struct, frozen=True, kw_only=True):
    """Limits of a gripper's drive, until its next goal."""

    gripper: Name | None = None
    """The robot's only one, if left out."""
    speed: float | None = None
    """Speed of the pads relative to each other [m/s]."""
    force: float | None = None
    """Force at each pad [N]."""
    effort: float | None = None
    """Instead of a force: of the driven joint [N·m | N]."""


class MoveJoints(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move joints smoothly; there is a goal for each trajectory controller."""

    positions: JointPositions
    speed: SpeedScale = 0.5
    duration: Annotated[float, Meta(gt=0.0)] | None = None
    """Instead of a speed: duration of the motions [s].  They are cubics, and the
    controllers' other joints keep their setpoints."""
    controller: Name | None = None
    """The controller whose joints they are; those that claim them, if left out."""
    collision: CollisionRule = "ignore"

    def as_done(self) -> Request[Any]:
        return structs.replace(self, collision="ignore")


class SteerJoints(Request[None], frozen=True):
    """Move joints of a trajectory controller smoothly, as streams of setpoints do."""

    controller: Name
    positions: JointPositions
    speed: SpeedScale = 0.5


class PoseJoints(Request[None], frozen=True):
    """Set joints directly; only in ``tool0 view``, which has no physics."""

    positions: JointPositions


class CommandGripper(Request[GoalStarted], frozen=True):
    """Send a gripper goal in joint units, as ROS's GripperCommand action does."""

    controller: Name
    position: float
    """Position of the gripper's joint [rad | m]."""
    max_effort: float | None = None
    """Largest effort [N·m | N]; the controller's own, if left out.  ROS 2's parallel
    gripper writes it to its ``max_effort_interface``: at the pads [N], if that is the
    gripper's."""
    max_velocity: float | None = None
    """Largest velocity of ROS 2's parallel gripper, for its ``max_velocity_interface``
    [rad/s | m/s], or between the pads [m/s]; the controller's own, if left out."""
    grip: GripLimits | None = None
    """Limits between the pads, instead of the two above."""


class CommandJoints(Request[None], frozen=True):
    """Send the setpoints of a forwarding controller."""

    controller: Name
    values: tuple[float, ...]
    """Values in the order of the controller's joints; the unit is its interface's."""
