"""Requests for collision-free motions: check, plan and execute."""

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
    """Target of one arm: joint positions, or a pose of the arm's tool."""

    arm: str | None = None
    """Name of the arm; required only if the robot has several arms."""
    positions: JointPositions = field(default_factory=dict)
    """Joint → target position [rad]; the other joints of the arm keep their
    positions."""
    pose: AnyPose | None = None
    """Target pose of the tool, instead of positions.  All postures that reach this pose
    are candidates, including postures that differ by full turns of joints.  The posture
    with the fastest motion is selected."""
    tip: str | None = None
    """Link fixed to the flange, in whose frame ``tool`` is given; the default is the
    flange."""
    tool: AnyPose | None = None
    """Pose of the tool in the frame of ``tip``; by default, the tool is at the frame of
    ``tip``."""
    relative_to: str | None = None
    """Link in whose frame the pose is given; the default is the robot's root.  If this
    link is ``tip``, the motion is relative to the current pose of the tool."""
    free_axis: Literal["x", "y", "z"] | None = None
    """Axis of the tool about which the rotation at the target is free."""


class KeepOut(Struct, frozen=True, kw_only=True):
    """A forbidden region for the robot: a box, or the half-space below a plane."""

    name: Name = "keep_out"
    """Name of the region in messages."""
    xyz: Place = (0.0, 0.0, 0.0)
    """Center of the box, or a point on the plane, in the robot's root frame [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Orientation of the box: fixed-axis roll, pitch and yaw [rad]."""
    size: tuple[Length, Length, Length] | None = None
    """Edge lengths of the box along x, y and z [m]."""
    normal: Vector3 | None = None
    """Normal of the plane, instead of a size; the normal points to the side that the
    robot may enter."""


class Upright(Struct, frozen=True, kw_only=True):
    """Constraint that keeps a tool axis within an angle of its initial direction."""

    tilt: Annotated[float, Meta(ge=0.01, le=3.2)]
    """Maximum angle between the axis and its initial direction [rad]."""
    axis: Vector3 = (0.0, 0.0, 1.0)
    """Axis of the tool that must stay upright, in the frame of ``tip``."""
    tip: str | None = None
    """Link that has the axis; the default is the arm's flange."""


class Checked(Struct, frozen=True, kw_only=True):
    """Result of checking whether a motion is free of collisions."""

    is_free: bool
    """Whether the motion is free of collisions, and all bodies keep the clearance."""
    reason: str = ""
    """The two bodies that are too close, and the distance between them; empty if the
    motion is free."""
    part: float = 1.0
    """Position of the violation on the path, from 0 to 1; 1 without a violation."""
    time: float = 0.0
    """Time of the violation after the start [s]; 0 without a violation."""


class Plan(Struct, frozen=True, kw_only=True):
    """A collision-free motion from rest to rest.

    Between two knots, the joints follow quintic polynomials.  Each row has one number
    per joint.
    """

    number: int
    """Number of the plan, which ``execute_plan`` requires."""
    joint_names: tuple[str, ...]
    """Names of the arms' joints; the joints of each arm are ordered from base to
    tip."""
    times: tuple[float, ...]
    """Times of the knots [s]; the first time is 0."""
    positions: Rows
    """Joint positions at the knots [rad], shape (n_knots, n_joints)."""
    velocities: Rows
    """Joint velocities at the knots [rad/s], shape (n_knots, n_joints)."""
    accelerations: Rows
    """Joint accelerations at the knots [rad/s²], shape (n_knots, n_joints)."""
    waypoints: Rows
    """Corner points of the path in joint space, from start to target [rad]."""
    clearance: float
    """Minimum distance on the path between bodies that must not touch [m]; at most
    1."""
    nearest: str
    """The two bodies with the minimum distance; empty if this distance is 1 m or
    more."""
    is_direct: bool
    """Whether the path is a straight line in joint space."""
    samples: int
    """Number of random postures that the search used."""
    poses: int
    """Number of poses at which distances were measured."""
    planning_time: float
    """Wall time of the planning [s]."""

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return self.times[-1]


class PlanMotion(Request[Plan], frozen=True):
    """Plan a collision-free motion from the commanded posture, without executing it."""

    targets: Annotated[tuple[PlanTarget, ...], Meta(min_length=1, max_length=4)]
    """One target for each moving arm; the arms move at the same time."""
    speed: SpeedScale = 0.5
    clearance: Annotated[float, Meta(ge=0.0, le=0.5)] = 0.005
    """Minimum allowed distance between bodies [m].  Bodies that are closer at the start
    are allowed to remain closer."""
    may_touch: tuple[Name, ...] = ()
    """Links and objects that the robot is allowed to touch, such as an object to
    grip."""
    keep_out: Annotated[tuple[KeepOut, ...], Meta(max_length=100)] = ()
    upright: Upright | None = None
    joint_ranges: Annotated[dict[str, Range], Meta(max_length=100)] = field(
        default_factory=dict
    )
    """Joint → narrower position limits for this motion [rad]."""
    timeout: Annotated[float, Meta(gt=0.0, le=600.0)] = 5.0
    """Wall time after which the search ends [s]."""
    seed: Annotated[int, Meta(ge=0, le=2**31)] = 0
    """Seed of the search; the same seed gives the same plan unless the search times
    out."""


class CancelPlanning(Request[None], frozen=True):
    """Cancel every search in progress; their ``plan_motion`` requests fail."""

    is_urgent = True


class ExecutePlan(Request[tuple[GoalStarted, ...]], frozen=True):
    """Execute a plan; each trajectory controller of the arms gets a goal.

    The plan is refused if the arm or an object has moved since the plan was made.  A
    new contact that the plan does not allow stops the motion.
    """

    number: int


class CheckMotion(Request[Checked], frozen=True):
    """Check whether an arm's motion would be collision-free, without executing it."""

    target: PlanTarget
    linear: bool = False
    """Whether the tool moves in a straight line; otherwise, the path is a straight line
    in joint space."""
    clearance: Annotated[float, Meta(ge=-0.01, le=0.5)] = 0.0
    """Minimum allowed distance between bodies [m]."""
    may_touch: tuple[Name, ...] = ()
    keep_out: Annotated[tuple[KeepOut, ...], Meta(max_length=100)] = ()
