"""The robot as immutable values, as returned by the strict URDF parser.

Lengths are in [m], angles in [rad], masses in [kg] and inertias in [kg·m²].  The effort
of a revolute joint is in [N·m], and that of a prismatic joint is in [N].  Frames follow
URDF and REP-103.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, TypeVar, final

from tool0.description.hardware_component import HardwareComponent
from tool0.description.shapes import RGBA, Geometry
from tool0.description.transform import Pose, Vector3
from tool0.description.units import ANGLE, LENGTH, Quantity
from tool0.errors import (
    DescriptionError,
    LimitsError,
    ModelError,
    SourceLocation,
    did_you_mean,
)

Item = TypeVar("Item")

FLANGE = "tool0"
"""Name of the link at the end of an arm, without prefix (REP-199)."""
DEFAULT_TURN_VELOCITY = 1.0
"""Velocity limit of revolute joints without a stated limit [rad/s].  The value is
deliberately low."""
DEFAULT_SLIDE_VELOCITY = 0.25
"""Velocity limit of prismatic joints without a stated limit [m/s]."""
TIME_TO_FULL_SPEED = 0.4
"""Time to accelerate from rest to the largest speed at the default acceleration limit
[s].  This value is an estimate, since datasheets do not state it.  With this value, the
acceleration limit of a UR5's shoulder is 7.9 rad/s², which the drive can achieve while
the arm is outstretched."""
_ROUNDING = 1e-3
"""Relative tolerance of the triangle inequality for principal moments of inertia.  CAD
programs export rounded numbers."""
ROBOTIQ: Final = "robotiq"
"""Protocol of Robotiq's grippers: the socket of the URCap, and Modbus registers."""
GRIPPER_PROTOCOLS: Final = (ROBOTIQ,)
"""Device protocols that a gripper can use."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Inertial:
    """Mass and inertia of a link."""

    mass: float
    origin: Pose = field(default_factory=Pose)
    """Pose of the center of mass and of the inertia's axes in the link's frame."""
    ixx: float
    ixy: float = 0.0
    ixz: float = 0.0
    iyy: float
    iyz: float = 0.0
    izz: float

    @property
    def principal_moments(self) -> Vector3:
        """The eigenvalues of the inertia [kg·m²], in ascending order.

        The eigenvalues are computed in closed form for symmetric 3 by 3 matrices,
        because NumPy is slow to import; see
        https://en.wikipedia.org/wiki/Eigenvalue_algorithm.
        """
        a, b, c = self.ixx, self.iyy, self.izz
        d, e, f = self.ixy, self.ixz, self.iyz
        off = d * d + e * e + f * f
        if off == 0.0:
            low, middle, high = sorted((a, b, c))
            return low, middle, high
        mean = (a + b + c) / 3
        a, b, c = a - mean, b - mean, c - mean
        spread = math.sqrt((a * a + b * b + c * c + 2 * off) / 6)
        determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
        cosine = determinant / (2 * spread**3)
        angle = math.acos(min(1.0, max(-1.0, cosine))) / 3
        high = mean + 2 * spread * math.cos(angle)
        low = mean + 2 * spread * math.cos(angle + 2 * math.pi / 3)
        return low, 3 * mean - high - low, high


def check_mass(mass: float, link: str, location: SourceLocation | None) -> None:
    """Raise ModelError unless a link's mass [kg] is above zero."""
    if not mass > 0:
        raise ModelError(
            f"link '{link}' has mass {mass:g} kg; give a mass above zero", location
        )


def check_protocol(name: str, location: SourceLocation | None) -> None:
    """Raise DescriptionError unless a gripper can use the protocol ``name``."""
    if name not in GRIPPER_PROTOCOLS:
        raise DescriptionError(
            f"unknown gripper protocol '{name}'; tool0 has "
            f"{', '.join(GRIPPER_PROTOCOLS)}; a gripper that speaks another one names "
            "none",
            location,
        )


def check_inertia(
    inertial: Inertial, link: str, location: SourceLocation | None
) -> None:
    """Raise ModelError if no body of positive mass can have this inertia."""
    low, middle, high = inertial.principal_moments
    moments = f"principal moments {low:.4g}, {middle:.4g}, {high:.4g} kg·m²"
    if not low > 0:
        raise ModelError(
            f"the inertia of link '{link}' is not positive definite ({moments}); "
            "check the signs and the products of inertia",
            location,
        )
    if not low + middle >= high * (1 - _ROUNDING):
        raise ModelError(
            f"physically impossible inertia of link '{link}' ({moments}): the largest "
            "must not exceed the sum of the others (triangle inequality); "
            "check the units and the axes",
            location,
        )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Visual:
    geometry: Geometry
    origin: Pose = field(default_factory=Pose)
    rgba: RGBA | None = None


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Collision:
    geometry: Geometry
    origin: Pose = field(default_factory=Pose)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """Contact properties of a gripping surface, from ``<gazebo reference=…>``."""

    mu1: float | None = None
    """Coulomb friction coefficient; None if the ``<gazebo>`` element does not state
    it."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    name: str
    inertial: Inertial | None = None
    visuals: tuple[Visual, ...] = ()
    collisions: tuple[Collision, ...] = ()
    surface: Surface | None = None
    self_collide: bool = False
    """Whether the link collides with links of the same robot for which this flag is
    also set."""


class JointType(enum.Enum):
    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"
    FIXED = "fixed"
    FLOATING = "floating"
    PLANAR = "planar"


RECOVERABLE = 0.05
"""Largest distance beyond a position limit at which a motion may start [rad | m].  A
push, a stop or manual guidance can move a joint beyond its limit."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointLimits:
    """Limits of one joint.  Infinity means unlimited; NaN is rejected.

    The units are [rad] and [N·m] for a revolute joint, and [m] and [N] for a prismatic
    joint.
    """

    lower: float = -math.inf
    """Smallest position [rad | m]."""
    upper: float = math.inf
    """Largest position [rad | m]."""
    velocity: float = math.inf
    """Largest speed in either direction [rad/s | m/s]."""
    effort: float = math.inf
    """Largest effort in either direction [N·m | N]."""
    acceleration: float = math.inf
    """Largest acceleration of planned motions [rad/s² | m/s²]."""
    jerk: float = math.inf
    """Largest jerk of planned motions [rad/s³ | m/s³]."""

    def __post_init__(self) -> None:
        if not self.lower <= self.upper:
            raise LimitsError(
                f"lower limit {self.lower} is above upper limit {self.upper}"
            )
        if not (self.velocity > 0 and self.effort >= 0):
            raise LimitsError(
                f"need velocity > 0 and effort >= 0, "
                f"got velocity {self.velocity}, effort {self.effort}"
            )
        if not (self.acceleration > 0 and self.jerk > 0):
            raise LimitsError(
                f"need acceleration > 0 and jerk > 0, "
                f"got acceleration {self.acceleration}, jerk {self.jerk}"
            )

    def clamp(self, position: float) -> float:
        """Return the allowed position nearest to ``position``."""
        return min(max(position, self.lower), self.upper)

    def range_from(self, start: float) -> tuple[float, float]:
        """Return the smallest and largest positions for a motion from ``start``.

        If the joint starts outside its limits, by up to ``RECOVERABLE``, the range is
        extended to the start position, so that the joint can return.
        """
        lower = min(self.lower, max(start, self.lower - RECOVERABLE))
        upper = max(self.upper, min(start, self.upper + RECOVERABLE))
        return lower, upper


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SafetyController:
    """Soft limits of a joint, from URDF's ``<safety_controller>``."""

    soft_lower_limit: float = -math.inf
    soft_upper_limit: float = math.inf
    k_position: float = 0.0
    k_velocity: float = 0.0


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Mimic:
    """Mimic relation: position = multiplier · position of ``joint`` + offset."""

    joint: str
    """The joint that determines the position."""
    multiplier: float = 1.0
    """Factor of the position of ``joint``."""
    offset: float = 0.0
    """Position while the position of ``joint`` is 0 [rad | m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Spring:
    """Spring in a joint: effort = stiffness · (reference - position)."""

    stiffness: float
    """Stiffness of the spring [N·m/rad | N/m]."""
    reference: float = 0.0
    """Position at which the spring exerts no effort [rad | m]."""


def shortest_turn(start: float, end: float) -> float:
    """Return the shortest rotation from ``start`` to ``end`` in (-π, π] [rad]."""
    turn = math.remainder(end - start, math.tau)
    return math.pi if turn == -math.pi else turn


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    name: str
    type: JointType
    parent: str
    child: str
    origin: Pose = field(default_factory=Pose)
    axis: Vector3 = (1.0, 0.0, 0.0)
    """Unit vector of the joint's axis in the joint's frame."""
    limits: JointLimits = field(default_factory=JointLimits)
    damping: float = 0.0
    friction: float = 0.0
    mimic: Mimic | None = None
    passive: bool = False
    """Whether the joint is driven only by a kinematic loop.  The joint's mimic relation
    is valid while nothing touches the loop."""
    spring: Spring | None = None
    safety: SafetyController | None = None

    @property
    def is_movable(self) -> bool:
        return self.type is not JointType.FIXED

    @property
    def max_velocity(self) -> float:
        """The joint's velocity limit [rad/s | m/s], or a low default value."""
        if math.isfinite(self.limits.velocity):
            return self.limits.velocity
        if self.type is JointType.PRISMATIC:
            return DEFAULT_SLIDE_VELOCITY
        return DEFAULT_TURN_VELOCITY

    @property
    def max_acceleration(self) -> float:
        """The joint's largest acceleration in planned motions [rad/s² | m/s²]."""
        return min(self.max_velocity / TIME_TO_FULL_SPEED, self.limits.acceleration)

    def clamp_velocity(self, velocity: float) -> float:
        """Return the allowed velocity nearest to ``velocity`` [rad/s | m/s]."""
        return min(max(velocity, -self.max_velocity), self.max_velocity)


class Interface(enum.Enum):
    """Command interface of a joint, with the name that ros_control uses."""

    EFFORT = "hardware_interface/EffortJointInterface"
    POSITION = "hardware_interface/PositionJointInterface"
    VELOCITY = "hardware_interface/VelocityJointInterface"


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Transmission:
    """A motor that drives a joint and makes it controllable."""

    name: str
    joint: str
    interfaces: tuple[Interface, ...]
    """Command interfaces of the drive, starting with the preferred interface.  Only one
    interface is active at a time."""
    mechanical_reduction: float = 1.0
    rotor_inertia: float = 0.0
    """Inertia of the rotor on the motor side of the transmission [kg·m²]."""
    gravity_compensation: bool = False
    """Whether the drive compensates for gravity, so that the commanded effort is added
    to the compensation.  Gravity compensation is meant for drives with a reduction so
    large that gravity hardly affects them."""
    command_limits: JointLimits = field(default_factory=JointLimits)
    """Limits of the drive's commands, in addition to the joint's limits."""

    @property
    def armature(self) -> float:
        """Rotor inertia reflected to the joint [kg·m²]."""
        return self.rotor_inertia * self.mechanical_reduction**2


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class LoopJoint:
    """Loop closure that keeps two points of different links at the same position."""

    name: str
    links: tuple[str, str]
    points: tuple[Vector3, Vector3]
    """Position of the common point in the frame of the first link and in the frame of
    the second link [m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RotaryOpening:
    """Opening of a gripper with a revolute joint that moves each pad along a circle.

    ``opening(q) = 2 (pad_offset + pad_cos · cos q + pad_sin · sin q)``.  This is the
    relation for parallelogram linkages.
    """

    pad_offset: float
    """Constant part of a pad's distance from the center [m]."""
    pad_cos: float
    """Coefficient of cos q in a pad's distance from the center [m]."""
    pad_sin: float
    """Coefficient of sin q in a pad's distance from the center [m]."""

    def opening(self, position: float) -> float:
        """Return the distance between the pads [m] at joint ``position`` [rad]."""
        return 2.0 * (
            self.pad_offset
            + self.pad_cos * math.cos(position)
            + self.pad_sin * math.sin(position)
        )

    def position(self, opening: float) -> float:
        """Return the position [rad] for ``opening`` [m] on the closing branch."""
        radius = math.hypot(self.pad_cos, self.pad_sin)
        phase = math.atan2(self.pad_sin, self.pad_cos)
        return phase + math.acos((opening / 2.0 - self.pad_offset) / radius)

    def lever(self, position: float) -> float:
        """Return ``|d opening / d position|`` [m/rad]."""
        return 2.0 * abs(
            self.pad_sin * math.cos(position) - self.pad_cos * math.sin(position)
        )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class LinearOpening:
    """Opening of a gripper with a prismatic joint that moves each pad along a line.

    ``opening(q) = 2 (pad_offset + pad_slope · q)``.
    """

    pad_offset: float
    """Distance of a pad from the center at q = 0 [m]."""
    pad_slope: float
    """Change in a pad's distance from the center [m] per unit of joint position.  If
    the value is negative, an increasing position closes the pads."""

    def opening(self, position: float) -> float:
        """Return the distance between the pads [m] at joint ``position`` [m]."""
        return 2.0 * (self.pad_offset + self.pad_slope * position)

    def position(self, opening: float) -> float:
        """Return the joint position [m] for an ``opening`` [m]."""
        return (opening / 2.0 - self.pad_offset) / self.pad_slope

    def lever(self, position: float) -> float:
        """Return ``|d opening / d position|``, which is independent of the position."""
        return 2.0 * abs(self.pad_slope)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ParallelGripper:
    """The relation between the opening of a parallel gripper and its driven joint.

    The gripper closes when the position of the joint increases, so a positive effort
    closes it.
    """

    name: str
    """Name of the gripper in the description, including the prefix."""
    joint: str
    """Name of the driven joint."""
    law: RotaryOpening | LinearOpening
    """Relation between the opening and the joint's position."""
    max_opening: float
    """Largest distance between the pads [m]."""
    speed: tuple[float, float]
    """Lowest and highest closing speed of the pads relative to each other [m/s]."""
    force: tuple[float, float]
    """Smallest and largest grip force at each pad [N]."""
    protocol: str | None = None
    """Device protocol of the gripper's ports, one of ``GRIPPER_PROTOCOLS``.  The value
    is None if the gripper does not use any of these protocols."""
    passive: tuple[tuple[str, Mimic], ...] = ()
    """Mimic relations of the linkage's joints.  The relations are valid while the pads
    are parallel, and invalid when the fingers wrap around an object."""

    @property
    def quantity(self) -> Quantity:
        """The physical quantity of the joint's position."""
        return LENGTH if isinstance(self.law, LinearOpening) else ANGLE

    def opening(self, position: float) -> float:
        """Return the distance between the pads [m] at joint ``position`` [rad | m]."""
        return self.law.opening(position)

    def position(self, opening: float) -> float:
        """Return the position [rad | m] for ``opening`` [m].

        Raises:
            ModelError: If the opening is outside the gripper's range.
        """
        if not 0.0 <= opening <= self.max_opening:
            raise ModelError(
                f"opening {opening} m of gripper '{self.name}' is outside "
                f"[0, {self.max_opening}] m"
                + LENGTH.suggestion(opening, lambda meant: meant <= self.max_opening)
            )
        return self.law.position(opening)

    def lever(self, position: float) -> float:
        """Return ``|d opening / d position|`` [m/rad | m/m] at ``position``.

        The joint's effort is the product of the grip force and this lever.
        """
        return self.law.lever(position)


@final
@dataclass(frozen=True)
class RobotModel:
    """A robot: a validated tree of links and joints."""

    name: str
    """Name of the robot in the URDF."""
    root: str
    """Name of the link without a parent.  Poses are in the frame of this link."""
    links: tuple[Link, ...]
    """The links, in URDF order."""
    joints: tuple[Joint, ...]
    """The joints in depth-first order from the root.  Children are in URDF order."""
    transmissions: tuple[Transmission, ...] = ()
    """Drives of the robot, with one drive per driven joint."""
    grippers: tuple[ParallelGripper, ...] = ()
    """Parallel grippers of the robot."""
    loops: tuple[LoopJoint, ...] = ()
    """Joints that close loops; each connects two links that the tree does not connect
    directly."""
    self_collide: bool = False
    """Whether all links collide with each other, regardless of each link's flag."""
    hardware: tuple[HardwareComponent, ...] = field(default=(), hash=False)
    """Contents of the ``<ros2_control>`` tags.  If the robot has no such tags, its
    drives are defined by ``<transmission>`` tags."""
    initial_positions: Mapping[str, float] = field(default_factory=dict, hash=False)
    """Start positions from the ``<ros2_control>`` tags, by joint [rad | m]."""
    locations: dict[str, SourceLocation] = field(
        default_factory=dict, compare=False, repr=False
    )
    """Source locations by ``link:NAME`` and ``joint:NAME``, for error messages."""

    @cached_property
    def link_by_name(self) -> dict[str, Link]:
        """The robot's links by name."""
        return {link.name: link for link in self.links}

    @cached_property
    def joint_by_name(self) -> dict[str, Joint]:
        """The robot's joints by name."""
        return {joint.name: joint for joint in self.joints}

    @cached_property
    def parent_joint(self) -> dict[str, Joint]:
        """The parent joint of each link other than the root."""
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def child_joints(self) -> dict[str, tuple[Joint, ...]]:
        """The child joints of each link."""
        below: dict[str, list[Joint]] = {link.name: [] for link in self.links}
        for joint in self.joints:
            below[joint.parent].append(joint)
        return {name: tuple(joints) for name, joints in below.items()}

    @cached_property
    def movable_joints(self) -> tuple[Joint, ...]:
        """The joints that are not fixed, in depth-first order."""
        return tuple(joint for joint in self.joints if joint.is_movable)

    @cached_property
    def transmission_by_joint(self) -> dict[str, Transmission]:
        """The drive of each driven joint."""
        return {item.joint: item for item in self.transmissions}

    @cached_property
    def wrench_sensors(self) -> dict[str, str]:
        """The links of the force-torque sensors in ``hardware``, by sensor name.

        The sensor's parameter ``frame_id`` contains the name of the link.  If the
        parameter does not contain the name of a link, the sensor's link is the flange
        with the same prefix as the sensor.  Sensors without a link are omitted.
        """
        found = {}
        for item in (item for component in self.hardware for item in component.items):
            named = item.parameters.get("frame_id", "")
            flanges = (
                flange
                for flange in self.flanges
                if item.name.startswith(flange.removesuffix(FLANGE))
            )
            link = (
                named
                if named in self.link_by_name
                else max(flanges, key=len, default="")
            )
            if item.is_force_torque_sensor and link:
                found[item.name] = link
        return found

    @cached_property
    def flanges(self) -> tuple[str, ...]:
        """The links at the ends of arms, called ``tool0`` with or without a prefix."""
        return tuple(link.name for link in self.links if link.name.endswith(FLANGE))

    def links_from(self, name: str) -> tuple[str, ...]:
        """Return the link ``name`` and all its descendants.

        Raises:
            ModelError: If there is no link of this name.
        """
        found = [self.link(name).name]
        for joint in self.child_joints[name]:
            found += self.links_from(joint.child)
        return tuple(found)

    def joint(self, name: str) -> Joint:
        """Return the joint called ``name``, or raise ModelError if there is none."""
        return _find("joint", name, self.joint_by_name)

    def link(self, name: str) -> Link:
        """Return the link called ``name``, or raise ModelError if there is none."""
        return _find("link", name, self.link_by_name)


def _find(kind: str, name: str, items: Mapping[str, Item]) -> Item:
    try:
        return items[name]
    except KeyError:
        hint = did_you_mean(name, list(items))
        raise ModelError(f"unknown {kind} '{name}'{hint}") from None
