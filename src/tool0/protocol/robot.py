"""The robot as a whole: description, constant properties, and newest state."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from msgspec import Struct, structs

from tool0.description.model import JointLimits
from tool0.description.transform import Transform
from tool0.protocol.controllers import Role
from tool0.protocol.request import Name, Request
from tool0.protocol.state import Snapshot

if TYPE_CHECKING:
    pass


class LimitsInfo(Struct, frozen=True, kw_only=True):
    """Limits of a joint; None where there is no limit."""

    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None
    acceleration: float | None
    """Largest acceleration of planned motions [rad/s² | m/s²]."""
    jerk: float | None
    """Largest jerk of planned motions [rad/s³ | m/s³]."""

    @staticmethod
    def of(limits: JointLimits) -> LimitsInfo:
        """Return limits in the form that is sent."""
        given = asdict(limits).items()
        return LimitsInfo(**{k: v if math.isfinite(v) else None for k, v in given})

    @property
    def limits(self) -> JointLimits:
        """The limits in the form of the model; infinite where there is no limit."""
        given = {k: v for k, v in structs.asdict(self).items() if v is not None}
        return JointLimits(**given)


class SimulationInfo(Struct, frozen=True, kw_only=True):
    """Properties of a simulation that are constant while a bring-up runs."""

    engine: str = ""
    """Name of the physics engine, ``mujoco`` or ``gazebo``; empty if there is none."""
    control_period: float
    """Simulated time of a tick [s]."""
    is_realtime: bool = True
    """Whether simulated time passes by itself, in real time."""
    spawn_z: float = 0.0
    """Height of the robot's root above the world's origin [m]."""
    ground: float | None = None
    """Height of the ground in the robot's root [m]; None without ground."""
    grasp_assist: bool = False
    """Whether grasp assist attaches gripped objects."""
    joint_limits: dict[str, LimitsInfo]
    """Limits of each driven joint: position [rad | m], velocity [rad/s | m/s], effort
    [N·m | N], acceleration and jerk."""
    defined_controllers: dict[str, str] = {}
    """Controllers in the YAML, loaded or not: name → type."""
    controller_roles: dict[str, Role] = {}
    """Roles of these controllers: name → role."""
    parameters: dict[str, Any] = {}
    """Complete content of the YAML, as plain values."""
    warnings: tuple[str, ...] = ()
    """Warnings about the YAML."""


class CatalogueRobotInfo(Struct, frozen=True, kw_only=True):
    """An arm with its gripper."""

    name: str
    """Name of the robot in its cell; empty for a single robot."""
    arm: str
    """Name of the arm's folder in the catalogue."""
    gripper: str | None
    """Name of the gripper's folder in the catalogue; None if there is no gripper."""
    prefix: str
    """Prefix of the arm's link and joint names."""


class NamespaceInfo(Struct, frozen=True, kw_only=True):
    """A robot of a cell that has its own namespace in ROS."""

    name: str
    """Name of the robot and of its namespace."""
    urdf: str
    """URDF of the robot alone, with unprefixed names."""


class DescriptionInfo(Struct, frozen=True, kw_only=True):
    """The robot's description."""

    urdf: str
    """The robot as one URDF document."""
    source: str
    """Path of the xacro or URDF file from which the robot was read."""
    robots: tuple[CatalogueRobotInfo, ...]
    """The robot's arms and grippers from the catalogue; empty for a user's own file."""
    namespaces: tuple[NamespaceInfo, ...]
    """The robots of a cell with namespaces; otherwise empty."""
    packages: dict[str, str]
    """ROS packages inside tool0 that the URDF refers to, with their ``file://``
    URIs."""


class ReadDescription(Request[DescriptionInfo], frozen=True):
    """Read the robot's description as URDF."""


class ReadInfo(Request[SimulationInfo], frozen=True):
    """Properties of a simulation that are constant while a bring-up runs."""


class ReadSnapshot(Request[Snapshot], frozen=True):
    """Read the newest state of the whole robot."""


class ReadLinkPose(Request[Transform], frozen=True):
    """Read the measured frame of a link."""

    link: Name
    relative_to: str | None = None
    """Link in whose frame the result is given; if left out, the robot's root."""


class ReadSummary(Request[dict[str, Any]], frozen=True):
    """Read a summary of the run as plain values."""
