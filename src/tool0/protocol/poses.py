"""Named poses of the robot, and the related requests."""

from __future__ import annotations

from tool0.description.named_pose import NamedPose
from tool0.protocol.goals import GoalStarted
from tool0.protocol.request import CollisionRule, Name, Request, SpeedScale


class ListPoses(Request[dict[str, NamedPose]], frozen=True):
    """List the built-in poses and the saved poses of the robot, by name."""


class SavePose(Request[None], frozen=True):
    """Save the measured positions of the driven joints as a pose."""

    name: Name
    robot: Name | None = None
    """Robot of the cell whose joints are saved.  If a pose with this name exists, its
    values for the other robots are kept.  By default, all joints are saved."""


class DeletePose(Request[None], frozen=True):
    """Delete a saved pose; the built-in poses cannot be deleted."""

    name: Name


class GoToPose(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move joints to a named pose; see ``MoveJoints``.

    A pose with arm joints does not move grippers, because a gripper may hold an
    object.  A pose with only gripper joints, such as ``open``, moves the grippers.
    """

    name: Name
    robot: Name | None = None
    """Robot of the cell whose joints move; by default, all robots move."""
    speed: SpeedScale = 0.5
    collision: CollisionRule = "ignore"
