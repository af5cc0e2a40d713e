"""Requests to an arm in terms of its tool's poses."""

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
"""A speed or an acceleration; the bounds exceed any arm's but avoid rounding errors."""


class ArmInfo(Struct, frozen=True, kw_only=True):
    """An arm: six revolute joints that end at a link ``…tool0``."""

    name: str
    """Prefix of the arm's links, or ``arm`` if they have none; in a cell, the robot's
    name."""
    base: str
    """Base link of the arm."""
    tip: str
    """Link at the end of the arm: the flange ``…tool0``."""
    joint_names: tuple[str, ...]
    """Names of the six joints, from base to tip."""
    rated_payload: float | None = None
    """Largest payload in the arm's data sheet, including the gripper [kg]; None if the
    arm is not in the catalogue."""


class ListArms(Request[tuple[ArmInfo, ...]], frozen=True):
    """List the robot's arms."""


class _OfTool(Request[Response], Generic[Response], frozen=True):
    """Common fields of requests about an arm's tool."""

    unchecked = ("pose", "tool")

    arm: str | None = None
    """Name of the arm; may be left out if the robot has only one."""
    tip: str | None = None
    """Link fixed to the flange, in which ``tool`` is given; if left out, the flange."""
    tool: AnyPose | None = None
    """Pose of the tool in the frame of ``tip``; if left out, the tool is ``tip``
    itself."""
    relative_to: str | None = None
    """Link in whose frame poses are given; if left out, the robot's root."""


class ReadToolPose(_OfTool[Transform], frozen=True):
    """Read the measured pose of the tool."""


class ReadBranch(Request[Branch], frozen=True):
    """Read which of the eight inverse-kinematics branches the arm is in."""

    arm: str | None = None


class SolveInverseKinematics(_OfTool[tuple[Solution, ...]], frozen=True, kw_only=True):
    """Find the postures that put the tool at a pose: one per branch, nearest first."""

    pose: AnyPose
    near: JointPositions = field(default_factory=dict)
    """Joint → position [rad] to which the postures should be near; for joints left out,
    the commanded position."""
    branch: Branch | None = None
    """Branch that the posture must belong to; if left out, any branch."""


class MoveTo(_OfTool[GoalStarted], frozen=True, kw_only=True):
    """Move the tool to a pose by a joint-space motion that is as fast as allowed."""

    pose: AnyPose
    speed: SpeedScale = 0.5
    near: JointPositions = field(default_factory=dict)
    branch: Branch | None = None
    collision: CollisionRule = "ignore"


class MoveLinear(_OfTool[GoalStarted], frozen=True, kw_only=True):
    """Move the tool to a pose along a straight line, which is checked beforehand."""

    pose: AnyPose
    speed: Rate = 0.25
    """Speed of the tool [m/s]; by default, this and the acceleration are the same as in
    UR's movel."""
    acceleration: Rate = 1.2
    """Acceleration of the tool [m/s²]; the rotation ramps over the same duration."""
    angular_speed: Rate = 1.0
    """Angular speed of the tool [rad/s]."""
    collision: CollisionRule = "ignore"
