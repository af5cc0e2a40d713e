"""The whole robot: description, constant properties, and newest state."""

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
    """Limits of a joint; None if there is no limit."""

    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None
    acceleration: float | None
    """Maximum acceleration of planned motions [rad/s² | m/s²]."""
    jerk: float | None
    """Maximum jerk of planned motions [rad/s³ | m/s³]."""

    @staticmethod
    def of(limits: JointLimits) -> LimitsInfo:
        """Return the sent form of limits."""
        given = asdict(limits).items()
        return LimitsInfo(**{k: v if math.isfinite(v) else None for k, v in given})

    @property
    def limits(self) -> JointLimits:
        """The limits in the form of the model; infinite if there is no limit."""
        given = {k: v for k, v in structs.asdict(self).items() if v is not None}
        return JointLimits(**given)


class SimulationInfo(Struct, frozen=True, kw_only=True):
    """Properties of a simulation that do not change during a bring-up."""

    engine: str = ""
    """Name of the physics engine, ``mujoco`` or ``gazebo``; empty if there is no
    engine."""
    control_period: float
    """Simulated time of a tick [s]."""
    is_realtime: bool = True
    """Whether simulated time passes automatically, in real time."""
    spawn_z: float = 0.0
    """Height of the robot's root above the origin of the world [m]."""
    ground: float | None = None
    """Height of the ground in the robot's root frame [m]; None without a ground."""
    grasp_assist: bool = False
    """Whether grasp assist attaches gripped objects to the gripper."""
    joint_limits: dict[str, LimitsInfo]
    """Limits of each driven joint: position [rad | m], velocity [rad/s | m/s], effort
    [N·m | N], acceleration and jerk."""
    defined_controllers: dict[str, str] = {}
    """All controllers in the YAML, including controllers that are not loaded: name →
    type."""
    controller_roles: dict[str, Role] = {}
    """Roles of the controllers in ``defined_controllers``: name → role."""
    parameters: dict[str, Any] = {}
    """Complete content of the controllers' YAML, as plain values."""
    warnings: tuple[str, ...] = ()
    """Warnings about the controllers' YAML."""


class CatalogueRobotInfo(Struct, frozen=True, kw_only=True):
    """An arm with its gripper, both from the catalog."""

    name: str
    """Name of the robot in its cell; empty for a single robot."""
    arm: str
    """Name of the arm's folder in the catalog."""
    gripper: str | None
    """Name of the gripper's folder in the catalog; None if there is no gripper."""
    prefix: str
    """Prefix of the arm's link and joint names."""


class NamespaceInfo(Struct, frozen=True, kw_only=True):
    """One robot of a cell, with a separate namespace in ROS."""

    name: str
    """Name of the robot and of its ROS namespace."""
    urdf: str
    """URDF of only this robot, in which the names have no prefix."""


class DescriptionInfo(Struct, frozen=True, kw_only=True):
    """The robot's description."""

    urdf: str
    """The whole robot as one URDF document."""
    source: str
    """Path of the xacro or URDF file from which the robot was read."""
    robots: tuple[CatalogueRobotInfo, ...]
    """The robot's arms and grippers from the catalog; empty if the robot is from a
    user's file."""
    namespaces: tuple[NamespaceInfo, ...]
    """The robots of a cell with their namespaces; empty if they have none."""
    packages: dict[str, str]
    """ROS packages in tool0 that the URDF refers to: name → ``file://`` URI of the
    package."""


class ReadDescription(Request[DescriptionInfo], frozen=True):
    """Read the robot's description as URDF."""


class ReadInfo(Request[SimulationInfo], frozen=True):
    """Read the properties of a simulation that do not change during a bring-up."""


class ReadSnapshot(Request[Snapshot], frozen=True):
    """Read the newest state of the whole robot."""


class ReadLinkPose(Request[Transform], frozen=True):
    """Read the measured frame of a link."""

    link: Name
    relative_to: str | None = None
    """Link in whose frame the result is given; the default is the robot's root."""


class ReadSummary(Request[dict[str, Any]], frozen=True):
    """Read a summary of the run as plain values."""
