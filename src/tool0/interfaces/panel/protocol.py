"""What page and server say to each other: the one definition of the panel's protocol.

Each message is a JSON object with its name in ``type``.  ``web/protocol.schema.json``
and the page's TypeScript types are made from the classes below, and
``docs/panel-protocol.md`` explains them.  Units are SI: [rad | m], [s], [N·m | N].
Numbers that are infinite in the model are null here, since JSON has no infinity.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal

from msgspec import UNSET, Meta, Struct, UnsetType

PROTOCOL: Final = 1
"""Raised by one when a program written for the old protocol could be misled."""

Mode = Literal["simulation", "view"]
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
SpeedScale = Annotated[float, Meta(ge=0.01, le=1.0)]
"""Part of each joint's largest velocity."""
Name = Annotated[str, Meta(min_length=1, max_length=200)]
Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""w, x, y, z."""
RGBA = tuple[float, float, float, float]
Length = Annotated[float, Meta(gt=0.0, le=100.0)]
"""[m]"""
Coordinate = Annotated[float, Meta(ge=-1000.0, le=1000.0)]
"""[m]"""
Place = tuple[Coordinate, Coordinate, Coordinate]


class _Request(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a page asks for; it is answered by a ``reply`` with the same ``id``."""

    id: Annotated[int, Meta(ge=0)]


class _Stream(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a page may send as fast as it likes.

    Only the newest counts, and only a mistake is answered.
    """


# ---- from the page, streams ---------------------------------------------------------


class Steer(_Stream, frozen=True, tag="steer"):
    """Send joints of a running trajectory controller to where a person's sliders are.

    The server replaces the controller's trajectory at most ten times a second, by a
    motion that starts as the joints move now; the last one is always carried out.
    """

    controller: Name
    positions: Annotated[dict[str, float], Meta(max_length=1000)]
    """Joint → where to; the controller's other joints stay where they are wanted."""
    speed: SpeedScale = 0.5


class PoseJoints(_Stream, frozen=True, tag="pose_joints"):
    """Put joints somewhere, in ``tool0 view``: nothing has weight there."""

    positions: Annotated[dict[str, float], Meta(max_length=1000)]


# ---- what requests are made of ------------------------------------------------------


class AddedShape(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The shape of an object to add: no mesh, since pages name no files."""

    kind: Literal["box", "cylinder", "sphere"]
    size: tuple[Length, Length, Length] | None = None
    """Edges of a box [m]."""
    radius: Length | None = None
    """Of a cylinder or a sphere [m]."""
    length: Length | None = None
    """Of a cylinder, along z [m]."""


# ---- from the page, requests --------------------------------------------------------


class GoToPose(_Request, frozen=True, tag="go_to_pose"):
    """Send every joint of a named pose there, by the running trajectory controllers."""

    name: Name
    speed: SpeedScale = 0.5


class SavePose(_Request, frozen=True, tag="save_pose"):
    """Keep the present joint positions under a name, on the server's machine."""

    name: Name


class DeletePose(_Request, frozen=True, tag="delete_pose"):
    """Forget a saved pose; those that came with the robot stay."""

    name: Name


class HoldStill(_Request, frozen=True, tag="hold_still"):
    """Stop the motion of a trajectory controller, as an empty trajectory does."""

    controller: Name


class Grip(_Request, frozen=True, tag="grip"):
    """Send the pads of a gripper to an opening."""

    gripper: Name
    opening: float
    """Distance between the pads [m]."""
    speed: float | None = None
    """Of the pads towards each other [m/s]; the fastest, if left out."""
    force: float | None = None
    """At each pad [N]; what the drive can do, if left out."""


class AddObject(_Request, frozen=True, tag="add_object"):
    """Put an object into the scene, at rest."""

    name: Name
    shape: AddedShape
    position: Place
    """Of its origin, in the robot's root [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""
    mass: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """[kg]; null stands still."""
    friction: Annotated[float, Meta(ge=0.0, le=100.0)] = 1.0
    rgba: RGBA | None = None
    """A colour of its own, if left out."""


class RemoveObject(_Request, frozen=True, tag="remove_object"):
    """Take an object out of the scene."""

    name: Name


class PlaceObject(_Request, frozen=True, tag="place_object"):
    """Put an object somewhere at once, at rest; a reset puts it back."""

    name: Name
    position: Place
    """Of its origin, in the robot's root [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""


class LoadController(_Request, frozen=True, tag="load_controller"):
    name: Name


class UnloadController(_Request, frozen=True, tag="unload_controller"):
    name: Name


class SwitchControllers(_Request, frozen=True, tag="switch_controllers"):
    """Stop and start controllers at one instant."""

    start: Annotated[list[Name], Meta(max_length=100)] = []
    stop: Annotated[list[Name], Meta(max_length=100)] = []
    strict: bool = True


class Pause(_Request, frozen=True, tag="pause"):
    pass


class Resume(_Request, frozen=True, tag="resume"):
    pass


class Step(_Request, frozen=True, tag="step"):
    """Run control periods while paused."""

    ticks: Annotated[int, Meta(ge=1, le=10_000)] = 1


class Reset(_Request, frozen=True, tag="reset"):
    """Start again at time zero, in the initial pose."""


class SetSpeed(_Request, frozen=True, tag="set_speed"):
    factor: Annotated[float, Meta(gt=0.0, le=1000.0)]
    """Simulated seconds per wall second."""


class EmergencyStop(_Request, frozen=True, tag="emergency_stop"):
    engaged: bool


Stream = Steer | PoseJoints
ClientMessage = (
    Steer
    | PoseJoints
    | GoToPose
    | SavePose
    | DeletePose
    | HoldStill
    | Grip
    | AddObject
    | RemoveObject
    | PlaceObject
    | LoadController
    | UnloadController
    | SwitchControllers
    | Pause
    | Resume
    | Step
    | Reset
    | SetSpeed
    | EmergencyStop
)


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
    """Something that happened; the last ones are in ``hello`` too."""

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

    The arrays are in the order of the joints of ``hello``.
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


class Hello(Struct, frozen=True, kw_only=True, tag="hello"):
    """The first message of the server; ``scene``, ``status`` and ``frame`` follow."""

    protocol: int
    version: str
    """Of tool0."""
    mode: Mode
    engine: str | None
    """``mujoco``; null in ``view``."""
    control_period: float | None
    """Simulated time of a tick [s]; null in ``view``."""
    grasp_assist: bool
    """Whether what is grasped is fixed to the gripper, which no hand does."""
    robot: RobotInfo
    notices: list[Notice]


class Problem(Struct, frozen=True, kw_only=True):
    """Why a request was refused."""

    kind: str
    """A class of tool0's error tree, such as ``ClaimError``."""
    message: str


class Reply(Struct, frozen=True, kw_only=True, tag="reply"):
    """The answer to one request."""

    id: int | None
    """The request's; null if what came was no message that could be answered."""
    error: Problem | UnsetType = UNSET


ServerMessage = Hello | Scene | Status | Frame | Notice | Reply
