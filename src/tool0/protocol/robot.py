"""The robot as a whole: its description, constant properties, and newest state."""

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
        """Return limits as they are sent."""
        given = asdict(limits).items()
        return LimitsInfo(**{k: v if math.isfinite(v) else None for k, v in given})

    @property
    def limits(self) -> JointLimits:
        """The limits as values of the model: infinite where there are none."""
        given = {k: v for k, v in structs.asdict(self).items() if v is not None}
        return JointLimits(**given)


class SimulationInfo(Struct, frozen=True, kw_only=True):
    """Properties that are constant while a bring-up runs."""

    engine: str = ""
    """Name of the physics engine, mujoco or gazebo; empty without one."""
    control_period: float
    """Simulated time of a tick [s]."""
    is_realtime: bool = True
    """Whether simulated time passes without requests."""
    spawn_z: float = 0.0
    """Height of the robot's root above the world's origin [m]."""
    ground: float | None = None
    """Height of the ground in the robot's root [m]; None without ground."""
    grasp_assist: bool = False
    """Whether grasp assist attaches gripped objects."""
    joint_limits: dict[str, LimitsInfo]
    """Limits of each driven joint [rad | m], [rad/s | m/s], [N·m | N], and so on."""
    defined_controllers: dict[str, str] = {}
    """Controllers of the YAML, loaded or not: name → type."""
    controller_roles: dict[str, Role] = {}
    """Role of each defined controller."""
    parameters: dict[str, Any] = {}
    """The whole YAML, as plain values."""
    warnings: tuple[str, ...] = ()
    """Findings about the YAML."""


class CatalogueRobotInfo(Struct, frozen=True, kw_only=True):
    """An arm with its gripper."""

    name: str
    """Name of the robot in its cell; empty for a single robot."""
    arm: str
    """The arm's folder."""
    gripper: str | None
    """The gripper's folder; None without one."""
    prefix: str
    """Prefix of the names of its links and joints."""


class NamespaceInfo(Struct, frozen=True, kw_only=True):
    """A robot of a cell that has a namespace of its own in ROS."""

    name: str
    """Name of the robot, and of its namespace."""
    urdf: str
    """The robot alone, with the names that it has alone."""


class DescriptionInfo(Struct, frozen=True, kw_only=True):
    """The robot's description."""

    urdf: str
    """The robot as one URDF document."""
    source: str
    """The xacro or URDF file it was read from."""
    robots: tuple[CatalogueRobotInfo, ...]
    """The robot's arms and grippers of the catalogue; none for your own file."""
    namespaces: tuple[NamespaceInfo, ...]
    """The robots of a cell with namespaces; otherwise none."""
    packages: dict[str, str]
    """``file://`` URIs of the ROS packages inside tool0, which the URDF refers to."""


class ReadDescription(Request[DescriptionInfo], frozen=True):
    """The robot's description as URDF."""


class ReadInfo(Request[SimulationInfo], frozen=True):
    """Properties that are constant while a bring-up runs."""


class ReadSnapshot(Request[Snapshot], frozen=True):
    """The newest state of the whole robot."""


class ReadLinkPose(Request[Transform], frozen=True):
    """The measured frame of a link."""

    link: Name
    relative_to: str | None = None
    """The link in whose frame it is; the root, if left out."""


class ReadSummary(Request[dict[str, Any]], frozen=True):
    """A summary of the run in plain values."""
