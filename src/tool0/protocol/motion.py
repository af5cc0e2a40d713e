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
    """Name of the gripper; may be left out if the robot has only one."""
    speed: float | None = None
    """Speed of the pads relative to each other [m/s]."""
    force: float | None = None
    """Force at each pad [N]."""
    effort: float | None = None
    """Effort of the driven joint [N·m | N], instead of a force."""


class MoveJoints(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move joints smoothly; each trajectory controller involved gets a goal."""

    positions: JointPositions
    speed: SpeedScale = 0.5
    duration: Annotated[float, Meta(gt=0.0)] | None = None
    """Duration of the motions [s], instead of a speed.  The motions are cubics, and the
    controllers' other joints keep their setpoints."""
    controller: Name | None = None
    """Controller that moves the joints; if left out, the controllers that claim
    them."""
    collision: CollisionRule = "ignore"

    def as_done(self) -> Request[Any]:
        return structs.replace(self, collision="ignore")


class SteerJoints(Request[None], frozen=True):
    """Move a trajectory controller's joints smoothly; for streams of setpoints."""

    controller: Name
    positions: JointPositions
    speed: SpeedScale = 0.5


class PoseJoints(Request[None], frozen=True):
    """Set joint positions directly; only in ``tool0 view``, which has no physics."""

    positions: JointPositions


class CommandGripper(Request[GoalStarted], frozen=True):
    """Send a gripper goal in joint units, like ROS's GripperCommand action."""

    controller: Name
    position: float
    """Position of the gripper's joint [rad | m]."""
    max_effort: float | None = None
    """Largest effort [N·m | N]; if left out, the controller's default.  ROS 2's
    parallel gripper controller writes it to its ``max_effort_interface``; if that
    interface is the gripper's, it is the force at the pads [N]."""
    max_velocity: float | None = None
    """Largest velocity [rad/s | m/s], which ROS 2's parallel gripper controller writes
    to its ``max_velocity_interface``; if that interface is the gripper's, it is the
    pads' relative speed [m/s].  If left out, the controller's default."""
    grip: GripLimits | None = None
    """Limits of the pads' speed and force, instead of the two above."""


class CommandJoints(Request[None], frozen=True):
    """Send setpoints to a forwarding controller."""

    controller: Name
    values: tuple[float, ...]
    """Values in the order of the controller's joints, in the unit of its interface."""
