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
    """Name of the arm; may be left out if the robot has only one."""
    positions: JointPositions = field(default_factory=dict)
    """Joint → position [rad]; the arm's other joints stay where they are."""
    pose: AnyPose | None = None
    """Pose of the tool, instead of positions.  All postures that reach it, including
    those that differ by full joint turns, are candidates; the fastest to reach is
    chosen."""
    tip: str | None = None
    """Link fixed to the flange, in which ``tool`` is given; if left out, the flange."""
    tool: AnyPose | None = None
    """Pose of the tool in the frame of ``tip``; if left out, the tool is ``tip``
    itself."""
    relative_to: str | None = None
    """Link in whose frame the pose is given; if left out, the robot's root.  With the
    tip itself, the motion is relative to the tool's current pose."""
    free_axis: Literal["x", "y", "z"] | None = None
    """Axis of the tool about which the tool may be rotated freely at the target."""


class KeepOut(Struct, frozen=True, kw_only=True):
    """A box, or the half-space below a plane, that the robot must not enter."""

    name: Name = "keep_out"
    """Name of the region, for messages."""
    xyz: Place = (0.0, 0.0, 0.0)
    """Centre of the box, or a point on the plane, in the robot's root [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw of the box [rad]."""
    size: tuple[Length, Length, Length] | None = None
    """Lengths of the box's edges [m]."""
    normal: Vector3 | None = None
    """Normal of the plane, instead of a size; it points to the side where the robot may
    be."""


class Upright(Struct, frozen=True, kw_only=True):
    """Constraint that keeps a tool axis within an angle of its initial direction."""

    tilt: Annotated[float, Meta(ge=0.01, le=3.2)]
    """Largest angle [rad]."""
    axis: Vector3 = (0.0, 0.0, 1.0)
    """Axis of the tool that must stay upright, in the frame of ``tip``."""
    tip: str | None = None
    """Link whose axis is meant; if left out, the arm's flange."""


class Checked(Struct, frozen=True, kw_only=True):
    """Result of checking whether a motion is free of collisions."""

    is_free: bool
    """Whether there are no collisions and no bodies come nearer than the clearance."""
    reason: str = ""
    """The two bodies that are too close, and their distance; empty if the motion is
    free."""
    part: float = 1.0
    """Position of the violation on the path, from 0 to 1; 1 if there is none."""
    time: float = 0.0
    """Time of the violation after the start [s]; 0 if there is none."""


class Plan(Struct, frozen=True, kw_only=True):
    """A collision-free motion from rest to rest.

    Between two knots, the joints follow quintics.  Each row has one number per joint.
    """

    number: int
    """Number of the plan, for ``execute_plan``."""
    joint_names: tuple[str, ...]
    """Names of the arms' joints, for each arm from base to tip."""
    times: tuple[float, ...]
    """Times of the knots [s]; the first is 0."""
    positions: Rows
    """Joint positions at the knots [rad], shape (n_knots, n_joints)."""
    velocities: Rows
    """Joint velocities at the knots [rad/s], shape (n_knots, n_joints)."""
    accelerations: Rows
    """Joint accelerations at the knots [rad/s²], shape (n_knots, n_joints)."""
    waypoints: Rows
    """Corner points of the path in joint space, from start to target [rad]."""
    clearance: float
    """Smallest distance on the way between bodies that must not touch [m]; at most
    1."""
    nearest: str
    """The two bodies with that distance; empty beyond 1 m."""
    is_direct: bool
    """Whether the motion is straight in joint space."""
    samples: int
    """Number of random poses that the search used."""
    poses: int
    """Number of poses at which distances were measured."""
    planning_time: float
    """Wall time that planning took [s]."""

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return self.times[-1]


class PlanMotion(Request[Plan], frozen=True):
    """Plan a collision-free motion from the commanded posture; nothing moves."""

    targets: Annotated[tuple[PlanTarget, ...], Meta(min_length=1, max_length=4)]
    """One target for each arm that moves; the arms move at the same time."""
    speed: SpeedScale = 0.5
    clearance: Annotated[float, Meta(ge=0.0, le=0.5)] = 0.005
    """Smallest allowed distance between bodies [m]; bodies that are closer at the start
    may stay so."""
    may_touch: tuple[Name, ...] = ()
    """Links and objects that the motion may touch, such as an object to be gripped."""
    keep_out: Annotated[tuple[KeepOut, ...], Meta(max_length=100)] = ()
    upright: Upright | None = None
    joint_ranges: Annotated[dict[str, Range], Meta(max_length=100)] = field(
        default_factory=dict
    )
    """Joint → narrower position limits for this motion [rad]."""
    timeout: Annotated[float, Meta(gt=0.0, le=600.0)] = 5.0
    """Wall time after which the search ends [s]."""
    seed: Annotated[int, Meta(ge=0, le=2**31)] = 0
    """Seed of the search; equal seeds give equal plans unless the time runs out."""


class CancelPlanning(Request[None], frozen=True):
    """Cancel every search in progress; ``plan_motion`` then fails with this reason."""

    is_urgent = True


class ExecutePlan(Request[tuple[GoalStarted, ...]], frozen=True):
    """Execute a plan; each trajectory controller involved gets a goal.

    The plan is refused if the arm or the scene has moved since planning.  Contacts that
    did not exist at the start and that the plan does not allow stop the motion.
    """

    number: int


class CheckMotion(Request[Checked], frozen=True):
    """Check whether a motion of an arm would be free of collisions; nothing moves."""

    target: PlanTarget
    linear: bool = False
    """Whether the tool moves on a straight line; otherwise, the motion is straight in
    joint space."""
    clearance: Annotated[float, Meta(ge=-0.01, le=0.5)] = 0.0
    """Smallest allowed distance between bodies [m]."""
    may_touch: tuple[Name, ...] = ()
    keep_out: Annotated[tuple[KeepOut, ...], Meta(max_length=100)] = ()
