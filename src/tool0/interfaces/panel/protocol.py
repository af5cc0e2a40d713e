"""The messages to a page after ``subscribe_view``: the robot as pages show it.

Each message is a JSON object with its name in ``type``.  ``web/protocol.schema.json``
and the page's TypeScript types are made from the classes below and the request table.
Units are SI: [rad | m], [s], [N·m | N].  Numbers that are infinite in the model are
null here, since JSON has no infinity.
"""

from __future__ import annotations

from typing import Literal

from msgspec import Struct

from tool0.control.controller import Role
from tool0.description.catalogue import DisplayName
from tool0.hardware.control_box import ControlBoxState
from tool0.requests.codec import Mode
from tool0.requests.table import RGBA, Quaternion, Vector3

Severity = Literal["info", "warning", "error"]
NoticeCode = Literal[
    "lint",
    "goal_succeeded",
    "goal_aborted",
    "goal_preempted",
    "overrun",
    "stall",
    "fault",
    "reset",
    "emergency_stop",
    "protective_stop",
    "arm_modes",
    "controllers",
    "refused",
    "log",
]

# ---- parts of messages ---------------------------------------------------------------


class JointInfo(Struct, frozen=True, kw_only=True):
    """A movable joint, as the controllers see it."""

    name: str
    type: Literal["revolute", "continuous", "prismatic"]
    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None
    driven: bool
    mimics: str | None
    """The joint it follows."""


class GripperInfo(Struct, frozen=True, kw_only=True):
    name: str
    joint: str
    max_opening: float
    """[m]"""
    min_speed: float
    max_speed: float
    """Of the pads towards each other [m/s]."""
    min_force: float
    max_force: float
    """At each pad [N]."""


class RobotPartsInfo(Struct, frozen=True, kw_only=True):
    """One of several robots: an arm with what it carries."""

    name: str
    """As requests call the arm: its name in a cell, or ``arm``."""
    title: str | None
    """Arm and gripper of the catalogue, ``ur5 + 2f85``; null for a user's own file."""
    prefix: str
    """What the names of its links and joints begin with; may be empty."""
    base: str
    """The link that carries this robot and no other."""
    joints: list[str]
    """Its movable joints, those of its gripper included."""
    gripper: str | None
    """The name of its gripper; null without one."""
    tip: str
    """The link at the end of the arm."""


class RobotInfo(Struct, frozen=True, kw_only=True):
    name: str
    title: str
    """For the title bar: ``ur5 + 2f85``."""
    root: str
    """The fixed link; every pose here is in its frame."""
    urdf: str
    """Path of the URDF on this server; it names its meshes by such paths."""
    ground: float | None
    """Height of the ground [m]; null for none."""
    joints: list[JointInfo]
    """In the order of every array of a ``frame``."""
    grippers: list[GripperInfo]
    robots: list[RobotPartsInfo]
    """The arms; one, unless it is a cell."""
    part_names: dict[str, DisplayName]
    """Link or joint → its name in English and Chinese, where it has one."""


class PartInfo(Struct, frozen=True, kw_only=True):
    """One of the shapes of an object, and its pose in the object's frame."""

    shape: ShapeInfo
    xyz: Vector3
    rpy: Vector3


class ShapeInfo(Struct, frozen=True, kw_only=True):
    """The shape of an object, centred at its origin; cylinders stand along z."""

    kind: Literal["box", "cylinder", "sphere", "mesh", "compound"]
    size: Vector3 | None = None
    """Edges of a box [m]; scale of a mesh."""
    radius: float | None = None
    length: float | None = None
    url: str | None = None
    """Path of a mesh on this server."""
    parts: list[PartInfo] | None = None
    """Of a compound: several shapes that are one rigid body."""


class ViewObject(Struct, frozen=True, kw_only=True):
    """An object of the scene."""

    name: str
    shape: ShapeInfo
    rgba: RGBA
    mass: float | None
    """[kg]; null is fixed."""


ControllerStage = Literal[
    "unloaded",
    "initialized",
    "running",
    "stopped",
    "unconfigured",
    "inactive",
    "active",
]
"""The states of ROS 1 and of ROS 2, and ``unloaded``."""


class ControllerInfo(Struct, frozen=True, kw_only=True):
    """A controller of the YAML, loaded or not."""

    name: str
    type: str
    state: ControllerStage
    is_running: bool
    role: Role
    """What it is for; sliders drive those that follow trajectories."""
    interface: str | None
    """The command interface it claims; null if it only reads, or is unloaded."""
    joints: list[str]
    """What it claims while it runs."""
    undrivable: str | None
    """Why its joints cannot be driven by sliders; null if they can."""


class GripperState(Struct, frozen=True, kw_only=True):
    name: str
    opening: float
    """[m]"""
    motion: Literal[
        "moving", "at_target", "holding_inside", "holding_outside", "blocked", "idle"
    ]
    """``holding_inside`` squeezes between the pads; ``holding_outside`` presses
    outwards; ``blocked`` cannot move on, without an object; ``idle`` if no controller
    moves it."""
    gobj: int
    """The same as Robotiq's ``gOBJ``: 0 moving, 1 and 2 stopped at an object
    while opening and closing, 3 at target."""
    width: float | None
    """Width of the object it holds [m]."""


class StallInfo(Struct, frozen=True, kw_only=True):
    """A joint that pushes at its effort limit and does not move."""

    joint: str
    effort: float
    """[N·m | N]"""
    contacts: list[tuple[str, str]]
    """Links beyond the joint, and what they touch; the strongest contact first."""


class PoseInfo(Struct, frozen=True, kw_only=True):
    name: str
    saved: bool
    """Whether it was saved; the others belong to the robot."""
    positions: dict[str, float]


# ---- from the server ----------------------------------------------------------------


class Notice(Struct, frozen=True, kw_only=True, tag="notice"):
    """An event in words, for the log; ``view`` holds the last ones."""

    number: int
    """Counts up from 1 for the life of the server."""
    wall_time: float
    """Seconds since 1970, UTC."""
    time: float | None
    """Simulated time [s]."""
    severity: Severity
    code: NoticeCode
    text: str
    """In English."""


class Status(Struct, frozen=True, kw_only=True, tag="status"):
    """Slowly changing state: sent first, and on every change."""

    paused: bool
    stopped: bool
    """Whether the emergency stop is engaged."""
    fault: str | None
    speed: float | None
    """Requested simulated seconds per wall second; null: as fast as possible."""
    real_time_factor: float
    """Measured over about the last second."""
    late_ticks: int
    """Ticks of about the last second that started late."""
    clients: int
    """Number of connected pages."""
    controllers: list[ControllerInfo]
    grippers: list[GripperState]
    poses: list[PoseInfo]
    stalls: list[StallInfo]
    targets: dict[str, float]
    """Joint → target of its controller's motion; the page draws it as a ghost."""
    control_boxes: list[ControlBoxState]
    """Of each arm: modes, program, pins, speed slider; empty without physics."""


class Frame(Struct, frozen=True, kw_only=True, tag="frame"):
    """Where everything is: at most 60 times a second of wall time, the newest only.

    If nothing changes, the same one is repeated five times a second.
    The arrays are in the order of the joints of ``view``.
    """

    time: float
    """Simulated [s]."""
    position: list[float]
    velocity: list[float]
    effort: list[float]
    desired: list[float | None]
    """Setpoints at this instant; null for joints that no controller moves by
    position."""
    objects: list[tuple[Vector3, Quaternion]]
    """Poses in the order of the objects of the ``scene`` with this number."""
    scene: int
    """Number of the ``scene`` that these objects are of."""


class ViewScene(Struct, frozen=True, kw_only=True, tag="scene"):
    """The objects around the robot: sent first, and when one is added or removed.

    A frame says by number which scene its objects are of.
    """

    number: int
    """Counts up from 0 for the life of the server."""
    objects: list[ViewObject]


class ViewInfo(Struct, frozen=True, kw_only=True, tag="view"):
    """The first message of the view; ``scene``, ``status`` and ``frame`` follow."""

    mode: Mode
    engine: str | None
    """``mujoco``; null in ``view``."""
    control_period: float | None
    """Simulated time of a tick [s]; null in ``view``."""
    grasp_assist: bool
    """Whether grasped objects are fixed to the gripper, which is not physical."""
    robot: RobotInfo
    notices: list[Notice]


ViewMessage = ViewInfo | ViewScene | Status | Frame | Notice
