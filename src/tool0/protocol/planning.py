"""Requests for collision-free motions: check, plan, execute."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from tool0.protocol.arm import AnyPose
from tool0.protocol.goals import GoalStarted
from tool0.protocol.request import (
    JointPositions,
    Length,
    Name,
    Place,
    Request,
    SpeedScale,
    Vector3,
)

Rows = tuple[tuple[float, ...], ...]

Range = tuple[float, float]


class PlanTarget(Struct, frozen=True, kw_only=True):
    """Target of one arm: joint positions, or a pose of its tool."""

    arm: str | None = None
    """The robot's only one, if left out."""
    positions: JointPositions = field(default_factory=dict)
    """Joint → position [rad]; other joints of the arm stay."""
    pose: AnyPose | None = None
    """Instead of positions: all postures that reach it are targets, with whole turns of
    the joints; the fastest to reach wins."""
    tip: str | None = None
    """A link that is fixed to the flange; the flange, if left out."""
    tool: AnyPose | None = None
    """The tool's pose in that link."""
    relative_to: str | None = None
    """The link in whose frame the pose is; the robot's root, if left out.  With the tip
    itself, the motion is relative to where the tool is."""
    free_axis: Literal["x", "y", "z"] | None = None
    """An axis of the tool about which it may be turned by any angle at the target."""


class KeepOut(Struct, frozen=True, kw_only=True):
    """A box, or the space below a plane, that the robot does not enter."""

    name: Name = "keep_out"
    """Name of the region, for messages."""
    xyz: Place = (0.0, 0.0, 0.0)
    """Centre of the box, or a point of the plane, in the robot's root [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw of the box [rad]."""
    size: tuple[Length, Length, Length] | None = None
    """Edges of the box [m]."""
    normal: Vector3 | None = None
    """Instead of a size: of the plane, to where the robot may be."""


class Upright(Struct, frozen=True, kw_only=True):
    """Keep an axis of the tool within an angle from where it points at the start."""

    tilt: Annotated[float, Meta(ge=0.01, le=3.2)]
    """Largest angle [rad]."""
    axis: Vector3 = (0.0, 0.0, 1.0)
    """Axis of the tool that is to stay upright."""
    tip: str | None = None
    """The link whose axis it is; the arm's flange, if left out."""


class Checked(Struct, frozen=True, kw_only=True):
    """Whether a motion is free."""

    is_free: bool
    """Whether nothing collides, and nothing comes nearer than the clearance."""
    reason: str = ""
    """The two bodies that are too near, and their distance; empty if the motion is
    free."""
    part: float = 1.0
    """Place of the violation on the path, from 0 to 1; 1 if there is none."""
    time: float = 0.0
    """Time of the violation after the start [s]; 0 if there is none."""


class Plan(Struct, frozen=True, kw_only=True):
    """A collision-free motion from rest to rest.

    Between two knots the joints follow quintics.  Rows have a number for each joint.
    """

    number: int
    """Number by which it is executed."""
    joint_names: tuple[str, ...]
    """Joints of each arm, from base to tip."""
    times: tuple[float, ...]
    """Times of the knots [s]; the first is 0."""
    positions: Rows
    """Joint positions at the knots [rad], shape (n_knots, n_joints)."""
    velocities: Rows
    """Joint velocities at the knots [rad/s], shape (n_knots, n_joints)."""
    accelerations: Rows
    """Joint accelerations at the knots [rad/s²], shape (n_knots, n_joints)."""
    waypoints: Rows
    """Joint positions at which the motion turns, from start to target [rad]."""
    clearance: float
    """Smallest distance on the way, of pairs that may not touch, up to 1 [m]."""
    nearest: str
    """The two bodies that come as near; empty beyond 1 m."""
    is_direct: bool
    """Whether the motion is straight in joint space."""
    samples: int
    """Random poses that the search used."""
    poses: int
    """Poses at which distances were measured."""
    planning_time: float
    """Wall time [s]."""

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return self.times[-1]


class PlanMotion(Request[Plan], frozen=True):
    """Plan a collision-free motion from the commanded posture; nothing moves."""

    targets: Annotated[tuple[PlanTarget, ...], Meta(min_length=1, max_length=4)]
    """One for each arm that moves: they move together."""
    speed: SpeedScale = 0.5
    clearance: Annotated[float, Meta(ge=0.0, le=0.5)] = 0.005
    """Smallest distance between bodies [m]; what is nearer at the start may stay so."""
    may_touch: tuple[Name, ...] = ()
    """Links and objects that the motion may touch, such as what is to be gripped."""
    keep_out: Annotated[tuple[KeepOut, ...], Meta(max_length=100)] = ()
    upright: Upright | None = None
    joint_ranges: Annotated[dict[str, Range], Meta(max_length=100)] = field(
        default_factory=dict
    )
    """Joint → narrower limits for this motion [rad]."""
    timeout: Annotated[float, Meta(gt=0.0, le=600.0)] = 5.0
    """Wall time after which the search ends [s]."""
    seed: Annotated[int, Meta(ge=0, le=2**31)] = 0
    """Seed of the search: the same one finds the same plan, unless the time runs
    out."""


class CancelPlanning(Request[None], frozen=True):
    """End every search in progress; ``plan_motion`` fails with the reason."""

    is_urgent = True


class ExecutePlan(Request[tuple[GoalStarted, ...]], frozen=True):
    """Follow a plan; there is a goal for each trajectory controller.

    It is refused if the arm or the scene has moved since it was planned.  A contact
    that was not there at the start, and is not allowed by the plan, stops the motion.
    """

    number: int


class CheckMotion(Request[Checked], frozen=True):
    """Whether a motion of an arm would be free; nothing moves."""

    target: PlanTarget
    linear: bool = False
    """Whether the tool is to move on a straight line; otherwise the joints do."""
    clearance: Annotated[float, Meta(ge=-0.01, le=0.5)] = 0.0
    """Smallest distance between bodies [m]."""
    may_touch: tuple[Name, ...] = ()
    keep_out: Annotated[tuple[KeepOut, ...], Meta(max_length=100)] = ()
