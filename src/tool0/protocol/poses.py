"""Named poses of the robot, and the requests to them."""

from __future__ import annotations

from tool0.description.named_pose import NamedPose
from tool0.protocol.goals import GoalStarted
from tool0.protocol.request import CollisionRule, Name, Request, SpeedScale


class ListPoses(Request[dict[str, NamedPose]], frozen=True):
    """The robot's own poses and the saved ones, by name."""


class SavePose(Request[None], frozen=True):
    """Save the measured positions of the driven joints on the simulation's machine."""

    name: Name
    robot: Name | None = None
    """Robot whose joints are saved; a saved pose of that name keeps those of the
    others.  All joints, if left out."""


class DeletePose(Request[None], frozen=True):
    """Delete a saved pose; the robot's own poses stay."""

    name: Name


class GoToPose(Request[tuple[GoalStarted, ...]], frozen=True):
    """Move the joints of a named pose there, as ``MoveJoints`` does.

    A pose with joints of an arm does not move its gripper, which may hold something; a
    pose with joints of grippers only, such as ``open``, moves those.
    """

    name: Name
    robot: Name | None = None
    """Robot whose joints move; all robots, if left out."""
    speed: SpeedScale = 0.5
    collision: CollisionRule = "ignore"
