"""The messages to a page after ``subscribe_view``: the robot as pages show it.

Each message is a JSON object with its name in ``type``.  ``web/protocol.schema.json``
and the page's TypeScript types are made from the classes below and the contract.
Units are SI: [rad | m], [s], [N·m | N].  Numbers that are infinite in the model are
null here, since JSON has no infinity.
"""

from __future__ import annotations

from typing import Literal

from msgspec import Struct

from tool0.description.catalogue import DisplayName
from tool0.protocol.codec import Mode
from tool0.protocol.control_box_state import ControlBoxState
from tool0.protocol.controllers import Role
from tool0.protocol.episodes import EpisodesStatus
from tool0.protocol.notifications import NoticeCode, Severity
from tool0.protocol.programs import ProgramRun
from tool0.protocol.request import RGBA, Vector3
from tool0.protocol.state_message import StateMessage

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
    """Largest opening of the gripper [m]."""
    min_speed: float
    max_speed: float
    """Largest speed of the pads towards each other [m/s]."""
    min_force: float
    max_force: float
    """Largest force at each pad [N]."""
    pad_offset: float
    pad_cos: float
    pad_sin: float
    pad_slope: float
    """Coefficient of q in the opening: with the joint at q, the opening is ``2
    (pad_offset + pad_cos cos q + pad_sin sin q + pad_slope q)``."""


class RobotPartsInfo(Struct, frozen=True, kw_only=True):
    """One of several robots: an arm with what it carries."""

    name: str
    """Name of the arm in requests: its name in a cell, or ``arm``."""
    title: str | None
    """Arm and gripper of the catalogue, ``ur5 + 2f85``; null for a user's own file."""
    prefix: str
    """Prefix of the names of its links and joints; may be empty."""
    base: str
    """The link that carries this robot and no other."""
    joints: list[str]
    """Movable joints of the robot, those of its gripper included."""
    gripper: str | None
    """The name of its gripper; null without one."""
    tip: str
    """The link at the end of the arm."""


class RobotInfo(Struct, frozen=True, kw_only=True):
    name: str
    title: str
    """Title for the title bar: ``ur5 + 2f85``."""
    root: str
    """The fixed link; every pose here is in its frame."""
    urdf: str
    """Path of the URDF on this server; it names its meshes by such paths."""
    ground: float | None
    """Height of the ground [m]; null for none."""
    joints: list[JointInfo]
    """Joints in the order of every array of a ``state``."""
    grippers: list[GripperInfo]
    robots: list[RobotPartsInfo]
    """The arms; one, unless it is a cell."""
    part_names: dict[str, DisplayName]
    """Link or joint → its name in English and Chinese, where it has one."""


class CameraInfo(Struct, frozen=True, kw_only=True):
    """A camera of the robot or of its scene."""

    name: str
    width: int
    """Width of the image [pixels]."""
    height: int
    far: float
    """Depth beyond which points are invisible [m]."""


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
    file: str | None = None
    """The file of a mesh on the simulation's machine, as ``add_object`` takes it."""
    parts: list[PartInfo] | None = None
    """Shapes of a compound, which are one rigid body."""


class ViewObject(Struct, frozen=True, kw_only=True):
    """An object of the scene."""

    name: str
    shape: ShapeInfo
    rgba: RGBA
    mass: float | None
    """Mass [kg]; null for a fixed object."""
    friction: float
    """Coulomb coefficient."""


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
    """Role of the controller; sliders drive those that follow trajectories."""
    interface: str | None
    """The command interface it claims; null if it only reads, or is unloaded."""
    joints: list[str]
    """Joints that it claims while it runs."""
    undrivable: str | None
    """Why its joints cannot be driven by sliders; null if they can."""


class GripperState(Struct, frozen=True, kw_only=True):
    name: str
    opening: float
    """Opening of the gripper [m]."""
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
    """Effort with which the joint pushes [N·m | N]."""
    contacts: list[tuple[str, str]]
    """Links beyond the joint, and what they touch; the strongest contact first."""


class PoseInfo(Struct, frozen=True, kw_only=True):
    name: str
    saved: bool
    """Whether it was saved; the others belong to the robot."""
    is_gripper: bool
    """Whether it is one of grippers only; the others do not move grippers."""
    positions: dict[str, float]
    """Positions of the joints that a move to it moves [rad | m]."""


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
    """Text in English."""


class RecordingInfo(Struct, frozen=True, kw_only=True):
    """A recording to a file."""

    file: str
    """The file that is written; the last one, after a rotation."""
    is_recording: bool
    seconds: int
    """Simulated time recorded [s]."""
    size: int
    """Size of all its files, in steps of 10 kB [bytes]."""
    dropped: int
    """Snapshots that are missing, because the disk was too slow."""
    error: str | None
    """Error that ended it early, such as a full disk."""


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
    """Control box of each arm: modes, program, pins, speed slider; empty without
    physics."""
    programs: list[ProgramRun]
    """The last program of each arm that ran one."""
    recording: RecordingInfo | None = None
    """The recording in progress, or the last one."""
    loops: bool = False
    """Whether a replay starts again at its end; ``paused`` and ``speed`` are its own,
    too."""
    episodes: EpisodesStatus | None = None
    """The folder of demonstrations, with whole seconds; null while there is none."""


class ViewScene(Struct, frozen=True, kw_only=True, tag="scene"):
    """The objects around the robot: sent first, and when one is added or removed.

    A state says by number which scene its objects are of.
    """

    number: int
    """Counts up from 0 for the life of the server."""
    objects: list[ViewObject]


class ReplayInfo(Struct, frozen=True, kw_only=True):
    """The recording that is replayed; its notices are those of ``view``."""

    file: str
    """Name of the file, without folders."""
    start: float
    """Simulated time of its first snapshot [s]."""
    end: float
    """Simulated time of its last snapshot [s]."""
    is_complete: bool
    """False if the file was cut off while it was written."""
    signals: list[str]
    """Names of the signals that ``read_replay`` returns: ``joint/elbow_joint/position``
    and so on."""


class ViewInfo(Struct, frozen=True, kw_only=True, tag="view"):
    """The first message of the view; ``scene``, ``status`` and ``state`` follow."""

    mode: Mode
    engine: str | None
    """``mujoco``; null in ``view``."""
    control_period: float | None
    """Simulated time of a tick [s]; null in ``view``."""
    grasp_assist: bool
    """Whether grasped objects are fixed to the gripper, which is not physical."""
    robot: RobotInfo
    cameras: list[CameraInfo]
    """``/cameras/NAME/color?width=640`` and ``/cameras/NAME/depth`` on this server are
    their images; see ``camera_images``."""
    notices: list[Notice]
    missing: dict[str, str]
    """Each method that this robot does not offer, and why."""
    replay: ReplayInfo | None = None
    """Recording that ``tool0 replay`` shows; null for a robot that runs."""


ViewMessage = ViewInfo | ViewScene | Status | StateMessage | Notice
