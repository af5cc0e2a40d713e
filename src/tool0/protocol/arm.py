"""Requests to an arm, by poses of its tool."""

from __future__ import annotations

from typing import Annotated, Generic

from msgspec import Meta, Struct, field

from tool0.description.posture import Branch, Solution
from tool0.description.transform import Pose, Transform
from tool0.protocol.goals import GoalStarted
from tool0.protocol.request import (
    CollisionRule,
    JointPositions,
    Request,
    Response,
    SpeedScale,
)

Row = tuple[float, float, float, float]

AnyPose = Pose | tuple[Row, Row, Row, Row]
"""Position and fixed-axis angles [m, rad], or a homogeneous matrix, shape (4, 4)."""

Rate = Annotated[float, Meta(ge=1e-6, le=1e6)]
"""A speed or an acceleration: far beyond any arm, yet safe from rounding errors."""


class ArmInfo(Struct, frozen=True, kw_only=True):
    """An arm: six revolute joints that end at a link ``…tool0``."""

    name: str
    """The prefix of its links, ``arm`` without one; in a cell, the robot's name."""
    base: str
    """The link that carries it."""
    tip: str
    """The link at its end."""
    joint_names: tuple[str, ...]
    """The six joints, from base to tip."""
    rated_payload: float | None = None
    """Largest payload of its data sheet, gripper and load together [kg]; None if the
    catalogue does not have it."""


class ListArms(Request[tuple[ArmInfo, ...]], frozen=True):
    """Every arm of the robot."""


class _OfTool(Request[Response], Generic[Response], frozen=True):
    """The fields of every request about a tool."""

    unchecked = ("pose", "tool")

    arm: str | None = None
    """The robot's only one, if left out."""
    tip: str | None = None
    """A link that is fixed to the flange; the flange, if left out."""
    tool: AnyPose | None = None
    """The tool's pose in that link."""
    relative_to: str | None = None
    """The link in whose frame poses are; the robot's root, if left out."""


class ReadToolPose(_OfTool[Transform], frozen=True):
    """The measured pose of the tool."""


class ReadBranch(Request[Branch], frozen=True):
    """The branch of the arm's posture, one of eight."""

    arm: str | None = None


class SolveInverseKinematics(_OfTool[tuple[Solution, ...]], frozen=True, kw_only=True):
    """The postures that put the tool at a pose: one per branch, nearest first."""

    pose: AnyPose
    near: JointPositions = field(default_factory=dict)
    """Joint → position [rad]; for joints left out, the commanded one."""
    branch: Branch | None = None
    """Branch that the posture must have; any, if left out."""


class MoveTo(_OfTool[GoalStarted], frozen=True, kw_only=True):
    """Move the tool to a pose along a curve, the joints as fast as allowed."""

    pose: AnyPose
    speed: SpeedScale = 0.5
    near: JointPositions = field(default_factory=dict)
    branch: Branch | None = None
    collision: CollisionRule = "ignore"


class MoveLinear(_OfTool[GoalStarted], frozen=True, kw_only=True):
    """Move the tool to a pose along a straight line that was checked before."""

    pose: AnyPose
    speed: Rate = 0.25
    """Speed of the tool [m/s]; this and the acceleration are the defaults of UR's
    movel."""
    acceleration: Rate = 1.2
    """Acceleration of the tool [m/s²]; the rotation ramps over the same duration."""
    angular_speed: Rate = 1.0
    """Angular speed of the tool [rad/s]."""
    collision: CollisionRule = "ignore"
