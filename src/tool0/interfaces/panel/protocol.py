"""What the panel receives after ``subscribe_view``: the robot as pages show it.

Each message is a JSON object with its name in ``type``.  ``web/protocol.schema.json``
and the page's TypeScript types are made from the classes below and the request table.
Units are SI: [rad | m], [s], [N·m | N].  Numbers that are infinite in the model are
null here, since JSON has no infinity.
"""

from __future__ import annotations

from typing import Literal

from msgspec import Struct

from tool0.requests.messages import Mode

Severity = Literal["info", "warning", "error"]
NoticeCode = Literal[
    "lint",
    "goal_succeeded",
    "goal_aborted",
    "goal_preempted",
    "overrun",
    "fault",
    "reset",
    "emergency_stop",
    "controllers",
    "refused",
    "log",
]
Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""w, x, y, z."""
RGBA = tuple[float, float, float, float]

# ---- what messages are made of ------------------------------------------------------


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


class PartName(Struct, frozen=True, kw_only=True):
    """What a person calls a link or a joint."""

    en: str
    zh: str


class RobotInfo(Struct, frozen=True, kw_only=True):
    name: str
    title: str
    """For people, as in ``ur5 + 2f85``."""
    root: str
    """The link that stands still; every pose here is in its frame."""
    urdf: str
    """Where the URDF is, as a path on this server; its meshes are by such paths too."""
    ground: float | None
    """Height of the ground [m]; null for none."""
    joints: list[JointInfo]
    """In the order of every array of a ``frame``."""
    grippers: list[GripperInfo]
    part_names: dict[str, PartName]
    """Link or joint → what a person calls it, where it has such a name."""


class ShapeInfo(Struct, frozen=True, kw_only=True):
    """The shape of an object, centred at its origin; cylinders stand along z."""

    kind: Literal["box", "cylinder", "sphere", "mesh"]
    size: Vector3 | None = None
    """Edges of a box [m]; scale of a mesh."""
    radius: float | None = None
    length: float | None = None
    url: str | None = None
    """Where a mesh is, as a path on this server."""


class ObjectInfo(Struct, frozen=True, kw_only=True):
    """An object of the scene."""

    name: str
    shape: ShapeInfo
    rgba: RGBA
    mass: float | None
    """[kg]; null for what stands still."""


class ControllerInfo(Struct, frozen=True, kw_only=True):
    """A controller of the YAML, loaded or not."""

    name: str
    type: str
    state: Literal["unloaded", "initialized", "running", "stopped"]
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
    motion: Literal["moving", "at_target", "holding_inside", "holding_outside", "idle"]
    """``holding_inside`` squeezes between the pads; ``holding_outside`` presses
    outwards; ``idle`` if no controller moves it."""
    gobj: int
    """The same as Robotiq's ``gOBJ`` has it: 0 moving, 1 and 2 stopped at an object
    while opening and closing, 3 at target."""
    width: float | None
    """Of what it holds [m]."""


class PoseInfo(Struct, frozen=True, kw_only=True):
    name: str
    saved: bool
    """Whether a person saved it; the others came with the robot."""
    positions: dict[str, float]


# ---- from the server ----------------------------------------------------------------


class Notice(Struct, frozen=True, kw_only=True, tag="notice"):
    """Something that happened; the last ones are in ``view`` too."""

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
    """What changes seldom: sent at the start, and when something in it changed."""

    paused: bool
    stopped: bool
    """Whether the emergency stop is engaged."""
    fault: str | None
    speed: float | None
    """Simulated per wall second, as asked for; null: as fast as possible."""
    real_time_factor: float
    """As measured over about the last second."""
    overruns: int
    clients: int
    """Pages that are connected."""
    controllers: list[ControllerInfo]
    grippers: list[GripperState]
    poses: list[PoseInfo]
    targets: dict[str, float]
    """Joint → where its controller is taking it; for the ghost."""


class Frame(Struct, frozen=True, kw_only=True, tag="frame"):
    """Where everything is: at most 60 times a second of wall time, the newest only.

    The arrays are in the order of the joints of ``view``.
    """

    time: float
    """Simulated [s]."""
    position: list[float]
    velocity: list[float]
    effort: list[float]
    desired: list[float | None]
    """Where controllers want the joints at this instant; null for joints that none
    moves by position."""
    objects: list[tuple[Vector3, Quaternion]]
    """Poses in the order of the objects of the ``scene`` with this number."""
    scene: int
    """Number of the ``scene`` that these objects are of."""


class Scene(Struct, frozen=True, kw_only=True, tag="scene"):
    """What is around the robot: sent at the start, and when an object comes or goes.

    A frame says by number which scene its objects are of.
    """

    number: int
    """Counts up from 0 for the life of the server."""
    objects: list[ObjectInfo]


class ViewInfo(Struct, frozen=True, kw_only=True, tag="view"):
    """The first message of the view; ``scene``, ``status`` and ``frame`` follow."""

    mode: Mode
    engine: str | None
    """``mujoco``; null in ``view``."""
    control_period: float | None
    """Simulated time of a tick [s]; null in ``view``."""
    grasp_assist: bool
    """Whether what is grasped is fixed to the gripper, which no hand does."""
    robot: RobotInfo
    notices: list[Notice]


ViewMessage = ViewInfo | Scene | Status | Frame | Notice
