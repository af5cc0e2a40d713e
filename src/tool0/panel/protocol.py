"""Messages to a page after ``subscribe_view``: the robot as shown on pages.

Each message is a JSON object with its name in ``type``.  ``web/protocol.schema.json``
and the page's TypeScript types are generated from the classes below and the contract.
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
    """A movable joint, as seen by controllers."""

    name: str
    type: Literal["revolute", "continuous", "prismatic"]
    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None
    driven: bool
    mimics: str | None
    """Name of the joint that this joint mimics; null if it mimics none."""


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
    pad_cos cos q + pad_sin sin q + pad_slope q)`` with the joint at q."""


class RobotPartsInfo(Struct, frozen=True, kw_only=True):
    """One of several robots: an arm with its gripper."""

    name: str
    """Name of the arm in requests: its name in a cell, or ``arm``."""
    title: str | None
    """Arm and gripper in the catalogue, such as ``ur5 + 2f85``; null for a user's own
    file."""
    prefix: str
    """Prefix of the robot's link and joint names; may be empty."""
    base: str
    """Base link of this robot, which carries no other robot."""
    joints: list[str]
    """Names of the robot's movable joints, including the gripper's."""
    gripper: str | None
    """Name of the robot's gripper; null if it has none."""
    tip: str
    """The link at the end of the arm."""


class RobotInfo(Struct, frozen=True, kw_only=True):
    name: str
    title: str
    """Title for the title bar, such as ``ur5 + 2f85``."""
    root: str
    """Fixed root link, in whose frame all poses are given."""
    urdf: str
    """Path of the URDF on this server; meshes in the URDF also have such paths."""
    ground: float | None
    """Height of the ground [m]; null if there is none."""
    joints: list[JointInfo]
    """Joints in the order of every array of a ``state``."""
    grippers: list[GripperInfo]
    robots: list[RobotPartsInfo]
    """The arms with their grippers; a cell has several."""
    part_names: dict[str, DisplayName]
    """Link or joint → display name in English and Chinese, if there is one."""


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
    """Coulomb coefficient of friction."""


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
    """A controller of the YAML, loaded or not."""

    name: str
    type: str
    state: ControllerStage
    is_running: bool
    role: Role
    """Role of the controller; sliders drive controllers that follow trajectories."""
    interface: str | None
    """Command interface that the controller claims; null if it only reads or is
    unloaded."""
    joints: list[str]
    """Joints that the controller claims while it is running."""
    undrivable: str | None
    """Reason why sliders cannot drive the controller's joints; null if they can."""


class GripperState(Struct, frozen=True, kw_only=True):
    name: str
    opening: float
    """Opening of the gripper [m]."""
    motion: Literal[
        "moving", "at_target", "holding_inside", "holding_outside", "blocked", "idle"
    ]
    """``holding_inside``: squeezes an object between the pads.  ``holding_outside``:
    presses the pads outwards against an object.  ``blocked``: cannot move on although
    nothing presses on both fingers.  ``idle``: no position controller is running."""
    gobj: int
    """Value of Robotiq's ``gOBJ``: 0: moving; 1: stopped by an object while opening; 2:
    stopped by an object while closing; 3: at target."""
    width: float | None
    """Width of the object between the pads [m]; null if there is none or it is
    unknown."""


class StallInfo(Struct, frozen=True, kw_only=True):
    """A joint that pushes at its effort limit and does not move."""

    joint: str
    effort: float
    """Effort with which the joint pushes [N·m | N]."""
    contacts: list[tuple[str, str]]
    """Pairs of a link beyond the joint and the body that it touches, the strongest
    contact first."""


class PoseInfo(Struct, frozen=True, kw_only=True):
    name: str
    saved: bool
    """Whether a user saved the pose; other poses come with the robot."""
    is_gripper: bool
    """Whether the pose is for grippers only; other poses do not move grippers."""
    positions: dict[str, float]
    """Positions of the joints that a move to the pose would move [rad | m]."""


# ---- from the server ----------------------------------------------------------------


class Notice(Struct, frozen=True, kw_only=True, tag="notice"):
    """An entry for the page's log; the ``view`` message has the most recent ones."""

    number: int
    """Number of the notice, counted from 1 during the server's lifetime."""
    wall_time: float
    """Wall time [s] since 1970, UTC."""
    time: float | None
    """Simulated time [s]."""
    severity: Severity
    code: NoticeCode
    text: str
    """Text of the notice in English."""


class RecordingInfo(Struct, frozen=True, kw_only=True):
    """A recording to a file."""

    file: str
    """Path of the current file; if the recording rotates, of the newest file."""
    is_recording: bool
    seconds: int
    """Simulated time recorded [s]."""
    size: int
    """Total size of the recording's files, rounded to 10 kB [bytes]."""
    dropped: int
    """Number of snapshots that are missing because the disk was too slow."""
    error: str | None
    """Error that ended the recording early, such as a full disk."""


class Status(Struct, frozen=True, kw_only=True, tag="status"):
    """Slowly changing state, sent at first and on every change."""

    paused: bool
    stopped: bool
    """Whether the emergency stop is engaged."""
    fault: str | None
    speed: float | None
    """Requested simulated seconds per wall second; null for as fast as possible."""
    real_time_factor: float
    """Simulated time per wall time, measured over about the last second."""
    late_ticks: int
    """Number of ticks that started late in about the last second."""
    clients: int
    """Number of connected pages."""
    controllers: list[ControllerInfo]
    grippers: list[GripperState]
    poses: list[PoseInfo]
    stalls: list[StallInfo]
    targets: dict[str, float]
    """Joint → target of its controller's motion [rad | m], which the page draws as a
    ghost."""
    control_boxes: list[ControlBoxState]
    """Control box of each arm: modes, program, pins, speed slider; empty without
    physics."""
    programs: list[ProgramRun]
    """Last program of each arm that has run one."""
    recording: RecordingInfo | None = None
    """State of the recording in progress or, if there is none, of the last one."""
    loops: bool = False
    """Whether a replay starts again at its end; in a replay, ``paused`` and ``speed``
    are also the replay's."""
    episodes: EpisodesStatus | None = None
    """State of the folder of demonstrations, in whole seconds; null if none is open."""


class ViewScene(Struct, frozen=True, kw_only=True, tag="scene"):
    """Objects around the robot, sent at first and when one is added or removed.

    A state's ``scene_number`` tells which scene its objects belong to.
    """

    number: int
    """Number of the scene, counted from 0 during the server's lifetime."""
    objects: list[ViewObject]


class ReplayInfo(Struct, frozen=True, kw_only=True):
    """The recording that is replayed; its notices are in the ``view`` message."""

    file: str
    """Name of the file, without folders."""
    start: float
    """Simulated time of its first snapshot [s]."""
    end: float
    """Simulated time of its last snapshot [s]."""
    is_complete: bool
    """False if the file was cut off while it was written."""
    signals: list[str]
    """Names of the signals that ``read_replay`` can return, such as
    ``joint/elbow_joint/position``."""


class ViewInfo(Struct, frozen=True, kw_only=True, tag="view"):
    """The first message of the view; ``scene``, ``status`` and ``state`` follow."""

    mode: Mode
    engine: str | None
    """Name of the physics engine, such as ``mujoco``; null without physics."""
    control_period: float | None
    """Simulated time of a tick [s]; null without physics."""
    grasp_assist: bool
    """Whether grasped objects are fixed to the gripper, which is not physical."""
    robot: RobotInfo
    cameras: list[CameraInfo]
    """Cameras, whose images are at ``/cameras/NAME/color?width=640`` and
    ``/cameras/NAME/depth`` on this server; see ``camera_images``."""
    notices: list[Notice]
    missing: dict[str, str]
    """Method that this robot does not offer → reason."""
    replay: ReplayInfo | None = None
    """Recording that ``tool0 replay`` shows; null for a running robot."""


ViewMessage = ViewInfo | ViewScene | Status | StateMessage | Notice
