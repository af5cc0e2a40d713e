"""The JSON objects that commands print with ``--json``.

Commands import this module for type checking only, so that mypy compares the keys that
they print with these types.  ``tools/cli_docs.py`` describes the types in
docs/reference/cli.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Final, NamedTuple, TypedDict, final

from tool0.api.dry_run import DryRun
from tool0.cli.demos.trials import DemoReport
from tool0.description.finding import FindingJson
from tool0.description.model import Mimic
from tool0.description.scene_state import ObjectState
from tool0.description.transform import Pose, Vector3
from tool0.installation.doctor.report import DoctorJson
from tool0.installation.gazebo.status import GazeboJson
from tool0.installation.ros1.packages import Ros1Json
from tool0.installation.ros2.status import Ros2Json
from tool0.policy.report import ReportJson
from tool0.protocol.control_box_state import RobotLink
from tool0.protocol.controllers import ControllerStatus, Gains
from tool0.protocol.goals import GoalResult, GripperResult
from tool0.protocol.gripper import GraspState
from tool0.protocol.planning import Checked
from tool0.protocol.programs import ProgramProblem, ProgramRun, SavedProgram
from tool0.protocol.recordings import RecordingStatus
from tool0.protocol.sensors import WrenchReading
from tool0.protocol.state import Stall
from tool0.recording.entries import RecordedEvent, RecordedRequest
from tool0.recording.resimulation import Resimulation
from tool0.recording.simulated_run import JointDifference
from tool0.simulation.summary import RunSummary

Joint = Annotated[str, "JOINT"]
Name = Annotated[str, "NAME"]


@final
class FieldsOf:
    """Marks a dict that has the fields of other types as its keys."""

    def __init__(self, *types: type) -> None:
        self.types = types


class _Gobj(TypedDict):
    gobj: int
    """Value of Robotiq's register gOBJ: 0 moving, idle or blocked; 1 and 2 holding an
    object, from inside and from outside; 3 at the target."""


Fields = dict[str, Any]
Grasp = Annotated[Fields, FieldsOf(GraspState, _Gobj)]


class CheckOutput(TypedDict):
    """Findings in files."""

    findings: list[FindingJson]
    """The findings, sorted by file and line."""
    files: list[str]
    """The files that were checked."""
    notes: tuple[str, ...]
    """Notes on checks that were not possible, with the reasons."""
    errors: int
    """Number of errors."""
    warnings: int
    """Number of warnings."""


class ControllersOutput(TypedDict):
    """The loaded controllers."""

    controllers: tuple[ControllerStatus, ...]
    """The controllers in load order."""


class GainsOutput(TypedDict):
    """The gains of a controller."""

    gains: Mapping[Joint, Gains]
    """The gains by joint."""


class StepOutput(TypedDict):
    """The time after the steps."""

    time: float
    """Simulated time [s]."""


class StateOutput(TypedDict):
    """The state of the robot."""

    time: float
    """Simulated time [s]."""
    is_paused: bool
    """Whether simulated time is paused."""
    is_stopped: bool
    """Whether the emergency stop is engaged."""
    real_time_factor: float
    """Simulated time per wall time; 0 until it is measured."""
    overruns: int
    """Number of ticks since the start that began more than one control period late."""
    late_ticks: int
    """Number of ticks in about the last second of wall time that began more than one
    control period late."""
    fault: str | None
    """Reason why the simulation has stopped until a reset."""
    stalls: list[Annotated[Fields, FieldsOf(Stall)]]
    """Driven joints that push without moving."""
    position: dict[Joint, float]
    """Measured position [rad | m]."""
    velocity: dict[Joint, float]
    """Measured velocity [rad/s | m/s]."""
    effort: dict[Joint, float]
    """Applied effort [N·m | N]."""
    grippers: dict[Name, Grasp]
    """State of each gripper."""
    poses: dict[Annotated[str, "LINK"], Annotated[Fields, FieldsOf(Pose)]]
    """Pose of each arm's flange in the robot's root frame."""


class CameraOutput(TypedDict):
    """A camera."""

    name: str
    """Name of the camera."""
    link: str | None
    """Link that carries the camera; null for the robot's root."""
    width: int
    """Width of the image [pixels]."""
    height: int
    """Height of the image [pixels]."""
    field_of_view: float
    """Vertical field of view [rad]."""
    near: float
    """Depth below which points are invisible [m]."""
    far: float
    """Depth beyond which points are invisible [m]."""


class CamerasOutput(TypedDict):
    """The cameras of the robot."""

    cameras: list[CameraOutput]
    """The cameras of the robot and of its scene."""


class PictureOutput(TypedDict):
    """A picture that was taken."""

    files: list[str]
    """The files that were written."""
    width: int
    """Width of the image [pixels]."""
    height: int
    """Height of the image [pixels]."""
    time: float
    """Simulated time of the image [s]."""


class LogOutput(TypedDict):
    """The entries of a recording."""

    duration: float
    """Simulated time from the first snapshot to the last snapshot [s]."""
    is_complete: bool
    """Whether the file was finished; otherwise, its end is missing."""
    entries: list[RecordedEvent | RecordedRequest]
    """Events and requests in chronological order."""


class _Shape(TypedDict):
    shape: dict[str, Any]
    """The shape: `kind` and its sizes ([requests.md](requests.md#values))."""
    mass: float | None
    """Mass [kg]; null for a fixed object."""
    friction: float
    """Coefficient of friction."""


class SceneOutput(TypedDict):
    """The objects around the robot."""

    objects: list[Annotated[Fields, FieldsOf(ObjectState, _Shape)]]
    """The objects."""


class ItemOutput(TypedDict):
    """An element of a launch file."""

    kind: str
    """Kind of the element, such as `include`, `node`, `param`, `argument` or `use`."""
    name: str
    """Name of the element."""
    value: str | None
    """Value of the element; null if it has no value or if its value is unknown."""
    file: str | None
    """The file that contains the element."""
    line: int | None
    """Line number, counted from 1."""
    note: str
    """Remark on the element, for example the reason why it is inactive."""
    items: list[ItemOutput]
    """Elements inside this element, with the same keys."""


class ExplainOutput(TypedDict):
    """The elements of a launch file."""

    contents: ItemOutput
    """The launch file."""
    arguments: list[ItemOutput]
    """The arguments of the launch file."""
    findings: list[FindingJson]
    """Findings in the launch file and in the files that it includes."""
    notes: list[str]
    """Notes on parts that could not be evaluated, with the reasons."""


class PolicyRunOutput(TypedDict):
    """A policy on a running robot."""

    result: str
    """`success`, `failure`, `stopped` or `interrupted`."""
    reason: str
    """Reason why the policy was stopped; empty if it was not stopped."""
    steps: int
    """Number of executed actions."""
    held_steps: int
    """Number of steps without an action, in which the robot held its position."""


class CollectOutput(TypedDict):
    """The collected data set."""

    folder: str
    """Folder of the data set."""
    episodes: int
    """Number of episodes."""
    succeeded: int
    """Number of episodes that succeeded."""
    frames: int
    """Number of frames."""
    bytes: int
    """Size of the data set [bytes]."""
    seconds: float
    """Duration [wall s]."""


class WayOutput(TypedDict):
    """A planned path."""

    duration: float
    """Duration of the motion [s]."""
    clearance: float
    """Smallest distance between two bodies along the path [m]."""
    nearest: str
    """The two bodies with the smallest distance; empty if it is 1 m or more."""
    is_direct: bool
    """Whether the direct motion was free of collisions."""
    waypoints: int
    """Number of waypoints, including the start and the target."""
    planning_time: float
    """Duration of the search [wall s]."""


class PlanOutput(TypedDict):
    """The planned path of a motion."""

    plan: WayOutput
    """The planned path."""


class _Canceled(TypedDict):
    canceled: bool
    """Whether Ctrl-C or `--timeout` ended the motion."""


class _Gripper(TypedDict):
    gripper: Grasp
    """State of the gripper after the motion."""


class PathOutput(TypedDict, total=False):
    """Whether there is a path around obstacles."""

    is_free: bool
    """Whether a path was found."""
    reason: str
    """Reason why there is no path; only without a path."""
    plan: WayOutput
    """The path; only if a path was found."""


class ProgramCheckOutput(TypedDict):
    """The check of a program."""

    problems: tuple[ProgramProblem, ...]
    """Problems that prevent the execution."""
    warnings: tuple[ProgramProblem, ...]
    """Further problems."""
    duration: float
    """Duration of the motions [s]."""


class ProgramsOutput(TypedDict):
    """The saved programs."""

    programs: Sequence[SavedProgram]
    """The saved programs."""


class JointOutput(TypedDict):
    """A joint of the robot."""

    name: str
    """Name of the joint."""
    type: str
    """Type of the joint in the URDF."""
    parent: str
    """Parent link."""
    child: str
    """Child link."""
    axis: Vector3
    """Axis of the joint in the joint's frame."""
    lower: float
    """Lower limit [rad | m]."""
    upper: float
    """Upper limit [rad | m]."""
    velocity: float
    """Largest speed [rad/s | m/s]."""
    effort: float
    """Largest effort [N·m | N]."""
    driven: list[str]
    """Command interfaces of the drive; empty without a drive."""
    mimic: Mimic | None
    """Relation to the joint that this joint follows; null if it follows none."""


class TreeOutput(TypedDict):
    """The joints of the robot."""

    root: str
    """Root link."""
    joints: list[JointOutput]
    """The joints, parents first."""


class HardwareOutput(TypedDict):
    """The state of a real robot."""

    link: RobotLink
    """The connection to the robot."""
    robot_mode: str
    """Mode of the arm, such as `RUNNING`."""
    safety_mode: str
    """Mode of the safety system, such as `NORMAL`."""
    program: str
    """State of tool0's program: `STOPPED`, `PLAYING` or `PAUSED`."""
    stopped: str
    """Reason why the arm stopped; empty if it did not stop."""
    speed_slider: float
    """Fraction of the programmed speed, 0.01 to 1."""


class ComparisonOutput(TypedDict):
    """A recording beside its simulation."""

    lag: float
    """Lag of the recorded arms behind the simulated arms [s]."""
    joints: Mapping[Joint, JointDifference]
    """Differences by driven joint, without the lag."""
    notes: tuple[str, ...]
    """Descriptions of the requests that were not repeated."""


class _IsIdentical(TypedDict):
    is_identical: bool
    """Whether every frame was bit-identical."""


class _Succeeded(TypedDict):
    succeeded: int
    """Number of objects that ended in the bin."""


class Output(NamedTuple):
    """An object that a command prints, and when it prints this object."""

    shape: Any
    """Type of the object."""
    when: str = ""
    """Condition in which the command prints the object."""


_TRAJECTORY: Final = Annotated[Fields, FieldsOf(GoalResult, _Canceled)]
_PICKS: Final = (Output(Annotated[Fields, FieldsOf(DemoReport, _Succeeded)]),)
OUTPUTS: Final[Mapping[str, tuple[Output, ...]]] = {
    "bringup": (Output(RunSummary),),
    "check": (Output(CheckOutput),),
    "collect": (Output(CollectOutput),),
    "camera": (
        Output(PictureOutput),
        Output(CamerasOutput, "With `--list`"),
    ),
    "controllers list": (Output(ControllersOutput),),
    "controllers gains": (Output(GainsOutput),),
    "demo pick": _PICKS,
    "demo handover": _PICKS,
    "demo shelf": _PICKS,
    "describe": (
        Output(TreeOutput, "For `tree` and `table`"),
        Output(
            dict[Annotated[str, "PART"], dict[str, Any]],
            "For `sources`, with the content of each part's `specifications.yaml`",
        ),
    ),
    "doctor": (Output(DoctorJson),),
    "explain": (Output(ExplainOutput),),
    "gazebo status": (Output(GazeboJson),),
    "grip": (
        Output(
            Annotated[Fields, FieldsOf(GripperResult, _Canceled, _Gripper)],
            "If a gripper controller moves the gripper",
        ),
        Output(
            Annotated[Fields, FieldsOf(GoalResult, _Canceled, _Gripper)],
            "If a trajectory controller moves the gripper",
        ),
    ),
    "hardware show": (Output(HardwareOutput),),
    "log": (Output(LogOutput),),
    "move": (
        Output(_TRAJECTORY),
        Output(
            Annotated[Fields, FieldsOf(GoalResult, _Canceled, PlanOutput)],
            "With `--plan`",
        ),
        Output(Checked, "With `--check`"),
        Output(PathOutput, "With `--plan --check`"),
    ),
    "policy run": (
        Output(ReportJson, "In a task"),
        Output(PolicyRunOutput, "On a running bringup"),
    ),
    "program list": (Output(ProgramsOutput),),
    "record": (Output(RecordingStatus),),
    "replay": (
        Output(
            Annotated[Fields, FieldsOf(_IsIdentical, Resimulation)],
            "With `--simulate`",
        ),
        Output(ComparisonOutput, "With `--compare`"),
    ),
    "ros1 status": (Output(Ros1Json),),
    "ros2 status": (Output(Ros2Json),),
    "run": (
        Output(ProgramRun),
        Output(ProgramCheckOutput, "With `--check`"),
        Output(DryRun, "With `--dry-run`"),
    ),
    "scene list": (Output(SceneOutput),),
    "state": (Output(StateOutput),),
    "step": (Output(StepOutput),),
    "wrench": (Output(WrenchReading),),
}
"""The objects that each command prints with ``--json``, by the command's words."""
