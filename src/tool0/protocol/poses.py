"""Named poses of the robot, and the related requests."""

from __future__ import annotations

from tool0.description.named_pose import NamedPose
from tool0.protocol.goals import GoalStarted
from tool0.protocol.request import CollisionRule, Name, Request, SpeedScale


class ListPoses(Request[dict[str, NamedPose]], frozen=True):
    """List the robot's own poses and the saved ones, by name."""


class SavePose(Request[None], frozen=True):
    """Save the measured positions of the driven joints as a pose."""

    name: Name
    robot: Name | None = None
    """Robot of the cell whose joints are saved; a saved pose of that name keeps the
    other robots' joints.  If left out, all joints are saved."""


class DeletePose(Request[None], frozen=True):
    """Delete a saved pose; the robot's own poses cannot be deleted."""

    name: Name


class GoToPose(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move joints to a named pose; see ``MoveJoints``.

    A pose with arm joints does not move grippers, which may hold something; a pose with
    gripper joints only, such as ``open``, moves these.
    """

    name: Name
    robot: Name | None = None
    """Robot of the cell whose joints move; if left out, all robots."""
    speed: SpeedScale = 0.5
    collision: CollisionRule = "ignore"
