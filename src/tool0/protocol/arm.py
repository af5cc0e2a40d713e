"""Requests that use poses of the tool to move an arm or to read its state."""

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
"""A speed or an acceleration.  The bounds are wider than the limits of every arm, but
narrow enough to avoid rounding errors."""


class ArmInfo(Struct, frozen=True, kw_only=True):
    """An arm: six revolute joints that end at a link ``…tool0``."""

    name: str
    """Name of the arm: the prefix of its links, or ``arm`` if they have no prefix; in a
    cell, the name of the robot."""
    base: str
    """Base link of the arm."""
    tip: str
    """Link at the end of the arm: the flange ``…tool0``."""
    joint_names: tuple[str, ...]
    """Names of the six joints, from base to tip."""
    rated_payload: float | None = None
    """Maximum payload in the data sheet of the arm, including the gripper [kg]; None if
    the arm is not in the catalog."""


class ListArms(Request[tuple[ArmInfo, ...]], frozen=True):
    """List the robot's arms."""


class _OfTool(Request[Response], Generic[Response], frozen=True):
    """Common fields of requests about the tool of an arm."""

    unchecked = ("pose", "tool")

    arm: str | None = None
    """Name of the arm; required only if the robot has several arms."""
    tip: str | None = None
    """Link fixed to the flange, in whose frame ``tool`` is given; the default is the
    flange."""
    tool: AnyPose | None = None
    """Pose of the tool in the frame of ``tip``; by default, the tool is at the frame of
    ``tip``."""
    relative_to: str | None = None
    """Link in whose frame poses are given; the default is the robot's root."""


class ReadToolPose(_OfTool[Transform], frozen=True):
    """Read the measured pose of the tool."""


class ReadBranch(Request[Branch], frozen=True):
    """Read the present inverse-kinematics branch of the arm, one of eight."""

    arm: str | None = None


class SolveInverseKinematics(_OfTool[tuple[Solution, ...]], frozen=True, kw_only=True):
    """Find the postures that reach a tool pose: one per branch, nearest first."""

    pose: AnyPose
    near: JointPositions = field(default_factory=dict)
    """Joint → position [rad]; the solutions are sorted by their distance from these
    positions.  For a joint that is left out, the commanded position is used."""
    branch: Branch | None = None
    """Branch of the posture; by default, all branches are allowed."""


class MoveTo(_OfTool[GoalStarted], frozen=True, kw_only=True):
    """Move the tool to a pose with the fastest allowed joint-space motion."""

    pose: AnyPose
    speed: SpeedScale = 0.5
    near: JointPositions = field(default_factory=dict)
    branch: Branch | None = None
    collision: CollisionRule = "ignore"


class MoveLinear(_OfTool[GoalStarted], frozen=True, kw_only=True):
    """Move the tool to a pose along a straight line; the line is checked first."""

    pose: AnyPose
    speed: Rate = 0.25
    """Speed of the tool [m/s].  The default speed and acceleration are the same as in
    URScript's ``movel``."""
    acceleration: Rate = 1.2
    """Acceleration of the tool [m/s²]; the rotation accelerates for the same
    duration."""
    angular_speed: Rate = 1.0
    """Angular speed of the tool [rad/s]."""
    collision: CollisionRule = "ignore"
