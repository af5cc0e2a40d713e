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
    """Limits of a gripper's drive, which apply until the gripper's next goal."""

    gripper: Name | None = None
    """Name of the gripper; required only if the robot has several grippers."""
    speed: float | None = None
    """Speed of the pads relative to each other [m/s]."""
    force: float | None = None
    """Force at each pad [N]."""
    effort: float | None = None
    """Effort of the driven joint [N·m | N], instead of a force."""


class MoveJoints(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move joints smoothly; each trajectory controller of the joints gets a goal."""

    positions: JointPositions
    speed: SpeedScale = 0.5
    duration: Annotated[float, Meta(gt=0.0)] | None = None
    """Duration of the motions [s], instead of a speed.  The motions are cubic
    polynomials.  The other joints of the controllers keep their setpoints."""
    controller: Name | None = None
    """Controller that moves the joints; by default, the controllers that claim them are
    used."""
    collision: CollisionRule = "ignore"

    def as_done(self) -> Request[Any]:
        return structs.replace(self, collision="ignore")


class SteerJoints(Request[None], frozen=True):
    """Move the joints of a trajectory controller smoothly.

    Use this request for streams of setpoints.
    """

    controller: Name
    positions: JointPositions
    speed: SpeedScale = 0.5


class PoseJoints(Request[None], frozen=True):
    """Set joint positions directly.

    Only ``tool0 view``, which has no physics, offers this request.
    """

    positions: JointPositions


class CommandGripper(Request[GoalStarted], frozen=True):
    """Send a gripper goal in joint units, as in ROS's GripperCommand action."""

    controller: Name
    position: float
    """Position of the gripper's joint [rad | m]."""
    max_effort: float | None = None
    """Maximum effort [N·m | N].  Without a value, the default of the controller
    applies.  ROS 2's parallel gripper controller writes this value to its
    ``max_effort_interface``.  If the gripper has this interface, the value is the force
    at the pads [N]."""
    max_velocity: float | None = None
    """Maximum velocity [rad/s | m/s].  Without a value, the default of the controller
    applies.  ROS 2's parallel gripper controller writes this value to its
    ``max_velocity_interface``.  If the gripper has this interface, the value is the
    relative speed of the pads [m/s]."""
    grip: GripLimits | None = None
    """Limits of the pads' speed and force, instead of ``max_effort`` and
    ``max_velocity``."""


class CommandJoints(Request[None], frozen=True):
    """Send setpoints to a forwarding controller."""

    controller: Name
    values: tuple[float, ...]
    """Values in the order of the controller's joints, in the unit of the controller's
    command interface."""
