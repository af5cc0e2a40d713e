"""Messages that contain the view of the robot, sent to a page that subscribed to it.

Each message is a JSON object with its name in ``type``.  ``web/protocol.schema.json``
and the page's TypeScript types are generated from the classes below and the contract.
Units are SI: [rad | m], [s], [N·m | N].  Infinite numbers of the model are null in
messages, because JSON has no infinity.
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
    """A movable joint, as it is used by controllers."""

    name: str
    type: Literal["revolute", "continuous", "prismatic"]
    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None
    driven: bool
    mimics: str | None
    """Name of the joint that this joint mimics; null if it does not mimic a joint."""


class GripperInfo(Struct, frozen=True, kw_only=True):
    name: str
    joint: str
    max_opening: float
    """Largest opening of the gripper [m]."""
    min_speed: float
    max_speed: float
    """Largest speed of the pads relative to each other [m/s]."""
    min_force: float
    max_force: float
    """Largest force at each pad [N]."""
    pad_offset: float
    pad_cos: float
    pad_sin: float
    pad_slope: float
    """Coefficient of q in the opening of the gripper, which is ``2 (pad_offset +
    pad_cos cos q + pad_sin sin q + pad_slope q)`` with the joint at the position q."""


class RobotPartsInfo(Struct, frozen=True, kw_only=True):
    """One of several robots: an arm with its gripper."""

    name: str
    """Name of the arm in requests, which is its name in a cell, or ``arm``."""
    title: str | None
    """Names of the arm and the gripper in the catalogue, such as ``ur5 + 2f85``; null
    for a user's file."""
    prefix: str
    """Prefix of the robot's link and joint names, which may be empty."""
    base: str
    """Base link of this robot, which does not carry another robot."""
    joints: list[str]
    """Names of the robot's movable joints, including those of the gripper."""
    gripper: str | None
    """Name of the robot's gripper; null if the robot has no gripper."""
    tip: str
    """The link at the end of the arm."""


class RobotInfo(Struct, frozen=True, kw_only=True):
    name: str
    title: str
    """Title for the title bar, such as ``ur5 + 2f85``."""
    root: str
    """Fixed root link; all poses are given in its frame."""
    urdf: str
    """Path of the URDF on this server; its meshes also have paths on this server."""
    ground: float | None
    """Height of the ground in the root frame [m]; null if there is no ground."""
    joints: list[JointInfo]
    """Joints in the order of the arrays in a ``state``."""
    grippers: list[GripperInfo]
    robots: list[RobotPartsInfo]
    """The arms with their grippers; a cell has several arms."""
    part_names: dict[str, DisplayName]
    """Display names in English and Chinese, by name of the link or joint."""


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
    """The shape of an object, centered at its origin; the axis of a cylinder is z."""

    kind: Literal["box", "cylinder", "sphere", "mesh", "compound"]
    size: Vector3 | None = None
    """Edges of a box [m], or scale factors of a mesh."""
    radius: float | None = None
    length: float | None = None
    url: str | None = None
    """Path of a mesh on this server."""
    file: str | None = None
    """File of a mesh on the simulation's machine, in the form that ``add_object``
    accepts."""
    parts: list[PartInfo] | None = None
    """Shapes of a compound, which form one rigid body."""


class ViewObject(Struct, frozen=True, kw_only=True):
    """An object of the scene."""

    name: str
    shape: ShapeInfo
    rgba: RGBA
    mass: float | None
    """Mass [kg]; null for a fixed object."""
    friction: float
    """Coulomb friction coefficient of the object."""


ControllerStage = Literal[
    "unloaded",
    "initialized",
    "running",
    "stopped",
    "unconfigured",
    "inactive",
    "active",
]
"""States of ROS 1 and ROS 2 controllers, and ``unloaded``."""


class ControllerInfo(Struct, frozen=True, kw_only=True):
    """A controller of the YAML file, which may be loaded or unloaded."""

    name: str
    type: str
    state: ControllerStage
    is_running: bool
    role: Role
    """Role of the controller; sliders command controllers that follow trajectories."""
    interface: str | None
    """Command interface that the controller claims; null if the controller only reads
    or is unloaded."""
    joints: list[str]
    """Joints that the controller claims while it is running."""
    undrivable: str | None
    """Reason why sliders cannot move the controller's joints; null if sliders can move
    them."""


class GripperState(Struct, frozen=True, kw_only=True):
    name: str
    opening: float
    """Opening of the gripper [m]."""
    motion: Literal[
        "moving", "at_target", "holding_inside", "holding_outside", "blocked", "idle"
    ]
    """``holding_inside``: The gripper squeezes an object between its pads.
    ``holding_outside``: The gripper presses its pads outward against an object.
    ``blocked``: The gripper cannot move further, although no object presses on both
    fingers.  ``idle``: No position controller of the gripper is running."""
    gobj: int
    """Value of Robotiq's ``gOBJ``: 0 (moving), 1 (stopped by an object while opening),
    2 (stopped by an object while closing) or 3 (at the target)."""
    width: float | None
    """Width of the object between the pads [m]; null if there is no object or its width
    is unknown."""


class StallInfo(Struct, frozen=True, kw_only=True):
    """A stationary joint that pushes with its largest effort."""

    joint: str
    effort: float
    """Effort with which the joint pushes [N·m | N]."""
    contacts: list[tuple[str, str]]
    """Contacts as pairs of a link beyond the joint and the body that it touches,
    starting with the strongest contact."""


class PoseInfo(Struct, frozen=True, kw_only=True):
    name: str
    saved: bool
    """Whether a user saved the pose; other poses are predefined."""
    is_gripper: bool
    """Whether the pose is only for grippers; other poses do not move grippers."""
    positions: dict[str, float]
    """Positions of the joints that a move to the pose would move [rad | m]."""


# ---- messages from the server --------------------------------------------------------


class Notice(Struct, frozen=True, kw_only=True, tag="notice"):
    """An entry for the page's log; the ``view`` message contains the latest entries."""

    number: int
    """Number of the notice, counted from 1 during the server's lifetime."""
    wall_time: float
    """Wall time of the notice [s since 1970 UTC]."""
    time: float | None
    """Simulated time of the notice [s]."""
    severity: Severity
    code: NoticeCode
    text: str
    """Text of the notice in English."""


class RecordingInfo(Struct, frozen=True, kw_only=True):
    """A recording to a file."""

    file: str
    """Path of the current file, which is the newest file if the recording is split."""
    is_recording: bool
    seconds: int
    """Recorded simulated time [s]."""
    size: int
    """Total size of the recording's files, rounded to 10 kB [bytes]."""
    dropped: int
    """Number of snapshots that are missing because the disk was too slow."""
    error: str | None
    """Error that ended the recording early, such as a full disk; null if there is no
    error."""


class Status(Struct, frozen=True, kw_only=True, tag="status"):
    """Slowly changing state, which is sent initially and at every change."""

    paused: bool
    stopped: bool
    """Whether the emergency stop is engaged."""
    fault: str | None
    speed: float | None
    """Requested simulated seconds per wall second; null if the simulation runs as fast
    as possible."""
    real_time_factor: float
    """Ratio of simulated time to wall time over roughly the last second."""
    late_ticks: int
    """Number of ticks that started late over roughly the last second."""
    clients: int
    """Number of connected pages."""
    controllers: list[ControllerInfo]
    grippers: list[GripperState]
    poses: list[PoseInfo]
    stalls: list[StallInfo]
    targets: dict[str, float]
    """Targets of the controllers' motions [rad | m] by joint, which the page draws as a
    ghost."""
    control_boxes: list[ControlBoxState]
    """Control box of each arm, with its modes, program, pins and speed slider; the list
    is empty without physics."""
    programs: list[ProgramRun]
    """Last program of each arm that has run a program."""
    recording: RecordingInfo | None = None
    """State of the current recording or, if there is no current recording, of the last
    recording."""
    loops: bool = False
    """Whether a replay starts again at its end; in a replay, ``paused`` and ``speed``
    also describe the playback."""
    episodes: EpisodesStatus | None = None
    """State of the open folder of demonstrations, with times in whole seconds; null if
    no folder is open."""


class ViewScene(Struct, frozen=True, kw_only=True, tag="scene"):
    """Objects around the robot, sent initially and when objects are added or removed.

    The field ``scene_number`` of a state is the number of the scene that contains the
    state's objects.
    """

    number: int
    """Number of the scene, counted from 0 during the server's lifetime."""
    objects: list[ViewObject]


class ReplayInfo(Struct, frozen=True, kw_only=True):
    """The replayed recording; its notices are in the ``view`` message."""

    file: str
    """Name of the recording's file, without folders."""
    start: float
    """Simulated time of the recording's first snapshot [s]."""
    end: float
    """Simulated time of the recording's last snapshot [s]."""
    is_complete: bool
    """Whether the file was finished; false if it was truncated while it was written."""
    signals: list[str]
    """Names of the signals that ``read_replay`` can return, such as
    ``joint/elbow_joint/position``."""


class ViewInfo(Struct, frozen=True, kw_only=True, tag="view"):
    """The first message of the view, before ``scene``, ``status`` and ``state``."""

    mode: Mode
    engine: str | None
    """Name of the physics engine, such as ``mujoco``; null without physics."""
    control_period: float | None
    """Duration of a tick in simulated time [s]; null without physics."""
    grasp_assist: bool
    """Whether grasped objects are fixed to the gripper, which is physically
    unrealistic."""
    robot: RobotInfo
    cameras: list[CameraInfo]
    """Cameras, with images at ``/cameras/NAME/color?width=640`` and
    ``/cameras/NAME/depth`` on this server; see ``camera_images``."""
    notices: list[Notice]
    missing: dict[str, str]
    """Reasons why this robot does not support some methods, by method."""
    replay: ReplayInfo | None = None
    """The recording that ``tool0 replay`` shows; null for a running robot."""


ViewMessage = ViewInfo | ViewScene | Status | StateMessage | Notice
