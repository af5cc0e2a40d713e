"""Simulation of UR arms with Robotiq grippers, and of the controllers that drive them.

Importing this package starts no process and imports no simulator: each name below is
loaded on first use.
"""

from __future__ import annotations

TYPE_CHECKING = False  # typing takes longer to import than this module
if TYPE_CHECKING:
    from tool0.api.arm import Arm, PlanOptions
    from tool0.api.arm_motion import ArmMotion
    from tool0.api.bringup import bringup
    from tool0.api.connect import connect
    from tool0.api.control_box import ControlBox
    from tool0.api.controller import ControllerHandle, GoalHandle
    from tool0.api.dry_run import DryRun, JointPeak, TouchReport
    from tool0.api.episodes import EpisodesHandle
    from tool0.api.grasps import Bin, find_bin
    from tool0.api.gripper import Gripper
    from tool0.api.programs import ProgramHandle, Programs
    from tool0.api.recording import Recording
    from tool0.api.robot import JointValues, Robot
    from tool0.api.scene import SceneHandle
    from tool0.api.sensors import CameraHandle, ForceTorque
    from tool0.batch.batch import Batch
    from tool0.batch.contacts import Contacts
    from tool0.batch.force_torque import BatchForceTorque
    from tool0.batch.saved import BatchState
    from tool0.cli.demos.hand import PickOptions
    from tool0.cli.demos.picker import pick_and_place
    from tool0.cli.demos.report import PickReport
    from tool0.control.config import ControllerConfig
    from tool0.description.config import Cell, CellRobot, DescriptionConfig
    from tool0.description.finding import Finding
    from tool0.description.model import JointLimits, ParallelGripper, RobotModel
    from tool0.description.named_pose import NamedPose
    from tool0.description.payload import Payload
    from tool0.description.posture import Branch, Solution
    from tool0.description.robot import RobotDescription
    from tool0.description.scene_state import Contact, ObjectState
    from tool0.description.transform import Pose, Transform
    from tool0.errors import (
        ClaimError,
        CollectError,
        CollisionError,
        ConfigError,
        ControlError,
        DescriptionError,
        DivergenceError,
        EngineError,
        EngineUnavailableError,
        GoalRejectedError,
        GoalTimeoutError,
        GymUnavailableError,
        LimitsError,
        ModelError,
        NoSuchPartError,
        NotOfferedError,
        PenetrationError,
        PlanningError,
        PolicyError,
        ProgramError,
        RecordingError,
        RenderError,
        RequestError,
        RosUnavailableError,
        SourceLocation,
        Tool0Error,
        TransportError,
        UnreachableError,
    )
    from tool0.kinematics.chain import ArmChain
    from tool0.kinematics.inverse import InverseKinematics
    from tool0.lint.check import CheckReport, check
    from tool0.panel.server import Panel
    from tool0.protocol.bus import (
        Faulted,
        GoalFinished,
        Overran,
        Subscription,
        WasReset,
    )
    from tool0.protocol.control_box_state import (
        AnalogDomain,
        AnalogPin,
        ControlBoxState,
        ProgramState,
        RobotMode,
        SafetyLimits,
        SafetyMode,
        UrReport,
    )
    from tool0.protocol.controllers import ControllerStatus, Gains
    from tool0.protocol.episodes import EpisodesStatus
    from tool0.protocol.goals import GoalResult, GoalStatus, GripperResult, Tolerance
    from tool0.protocol.gripper import GraspState
    from tool0.protocol.objects import Collision
    from tool0.protocol.planning import Checked, KeepOut, Plan, PlanTarget, Upright
    from tool0.protocol.program import (
        CommentStep,
        GripperStep,
        LoopStep,
        MoveJointStep,
        MoveLinearStep,
        PlaceObjectStep,
        Program,
        SetOutputStep,
        ToolPose,
        UntilStep,
        WaitStep,
    )
    from tool0.protocol.programs import (
        ProgramCheck,
        ProgramProblem,
        ProgramRun,
        SavedProgram,
    )
    from tool0.protocol.recordings import RecordingStatus
    from tool0.protocol.robot import SimulationInfo
    from tool0.protocol.sensors import CameraImage, WrenchReading
    from tool0.protocol.state import ArmSample, JointSetpoint, Snapshot
    from tool0.protocol.trajectories import (
        JointsMotion,
        TrajectoryPoint,
        TrajectoryState,
    )
    from tool0.recording.entries import RecordedEvent, RecordedRequest
    from tool0.recording.png import encode_depth, encode_png
    from tool0.recording.reading import RecordingFile, open_recording
    from tool0.recording.video_writer import VideoWriter
    from tool0.ros1.bridge import Ros1Bridge
    from tool0.ros1.options import Ros1Options
    from tool0.ros2.node import Ros2Node
    from tool0.ros2.options import Ros2Options
    from tool0.simulation.config import ControlConfig, SimulationConfig
    from tool0.ur.options import UrArm, UrOptions
    from tool0.ur.process import UrController

__all__ = [
    "AnalogDomain",
    "AnalogPin",
    "Arm",
    "ArmChain",
    "ArmMotion",
    "ArmSample",
    "Batch",
    "BatchForceTorque",
    "BatchState",
    "Bin",
    "Branch",
    "CameraHandle",
    "CameraImage",
    "Cell",
    "CellRobot",
    "CheckReport",
    "Checked",
    "ClaimError",
    "CollectError",
    "Collision",
    "CollisionError",
    "CommentStep",
    "ConfigError",
    "Contact",
    "Contacts",
    "ControlBox",
    "ControlBoxState",
    "ControlConfig",
    "ControlError",
    "ControllerConfig",
    "ControllerHandle",
    "ControllerStatus",
    "DescriptionConfig",
    "DescriptionError",
    "DivergenceError",
    "DryRun",
    "EngineError",
    "EngineUnavailableError",
    "EpisodesHandle",
    "EpisodesStatus",
    "Faulted",
    "Finding",
    "ForceTorque",
    "Gains",
    "GoalFinished",
    "GoalHandle",
    "GoalRejectedError",
    "GoalResult",
    "GoalStatus",
    "GoalTimeoutError",
    "GraspState",
    "Gripper",
    "GripperResult",
    "GripperStep",
    "GymUnavailableError",
    "InverseKinematics",
    "JointLimits",
    "JointPeak",
    "JointSetpoint",
    "JointValues",
    "JointsMotion",
    "KeepOut",
    "LimitsError",
    "LoopStep",
    "ModelError",
    "MoveJointStep",
    "MoveLinearStep",
    "NamedPose",
    "NoSuchPartError",
    "NotOfferedError",
    "ObjectState",
    "Overran",
    "Panel",
    "ParallelGripper",
    "Payload",
    "PenetrationError",
    "PickOptions",
    "PickReport",
    "PlaceObjectStep",
    "Plan",
    "PlanOptions",
    "PlanTarget",
    "PlanningError",
    "PolicyError",
    "Pose",
    "Program",
    "ProgramCheck",
    "ProgramError",
    "ProgramHandle",
    "ProgramProblem",
    "ProgramRun",
    "ProgramState",
    "Programs",
    "RecordedEvent",
    "RecordedRequest",
    "Recording",
    "RecordingError",
    "RecordingFile",
    "RecordingStatus",
    "RenderError",
    "RequestError",
    "Robot",
    "RobotDescription",
    "RobotMode",
    "RobotModel",
    "Ros1Bridge",
    "Ros1Options",
    "Ros2Node",
    "Ros2Options",
    "RosUnavailableError",
    "SafetyLimits",
    "SafetyMode",
    "SavedProgram",
    "SceneHandle",
    "SetOutputStep",
    "SimulationConfig",
    "SimulationInfo",
    "Snapshot",
    "Solution",
    "SourceLocation",
    "Subscription",
    "Tolerance",
    "Tool0Error",
    "ToolPose",
    "TouchReport",
    "TrajectoryPoint",
    "TrajectoryState",
    "Transform",
    "TransportError",
    "UnreachableError",
    "UntilStep",
    "Upright",
    "UrArm",
    "UrController",
    "UrOptions",
    "UrReport",
    "VideoWriter",
    "WaitStep",
    "WasReset",
    "WrenchReading",
    "bringup",
    "check",
    "connect",
    "encode_depth",
    "encode_png",
    "find_bin",
    "open_recording",
    "pick_and_place",
]

_HOMES = {
    "AnalogDomain": "tool0.protocol.control_box_state",
    "AnalogPin": "tool0.protocol.control_box_state",
    "Arm": "tool0.api.arm",
    "ArmChain": "tool0.kinematics.chain",
    "ArmMotion": "tool0.api.arm_motion",
    "ArmSample": "tool0.protocol.state",
    "Batch": "tool0.batch.batch",
    "BatchForceTorque": "tool0.batch.force_torque",
    "BatchState": "tool0.batch.saved",
    "Bin": "tool0.api.grasps",
    "Branch": "tool0.description.posture",
    "CameraHandle": "tool0.api.sensors",
    "CameraImage": "tool0.protocol.sensors",
    "Cell": "tool0.description.config",
    "CellRobot": "tool0.description.config",
    "CheckReport": "tool0.lint.check",
    "Checked": "tool0.protocol.planning",
    "ClaimError": "tool0.errors",
    "CollectError": "tool0.errors",
    "Collision": "tool0.protocol.objects",
    "CollisionError": "tool0.errors",
    "CommentStep": "tool0.protocol.program",
    "ConfigError": "tool0.errors",
    "Contact": "tool0.description.scene_state",
    "Contacts": "tool0.batch.contacts",
    "ControlBox": "tool0.api.control_box",
    "ControlBoxState": "tool0.protocol.control_box_state",
    "ControlConfig": "tool0.simulation.config",
    "ControlError": "tool0.errors",
    "ControllerConfig": "tool0.control.config",
    "ControllerHandle": "tool0.api.controller",
    "ControllerStatus": "tool0.protocol.controllers",
    "DescriptionConfig": "tool0.description.config",
    "DescriptionError": "tool0.errors",
    "DivergenceError": "tool0.errors",
    "DryRun": "tool0.api.dry_run",
    "EngineError": "tool0.errors",
    "EngineUnavailableError": "tool0.errors",
    "EpisodesHandle": "tool0.api.episodes",
    "EpisodesStatus": "tool0.protocol.episodes",
    "Faulted": "tool0.protocol.bus",
    "Finding": "tool0.description.finding",
    "ForceTorque": "tool0.api.sensors",
    "Gains": "tool0.protocol.controllers",
    "GoalFinished": "tool0.protocol.bus",
    "GoalHandle": "tool0.api.controller",
    "GoalRejectedError": "tool0.errors",
    "GoalResult": "tool0.protocol.goals",
    "GoalStatus": "tool0.protocol.goals",
    "GoalTimeoutError": "tool0.errors",
    "GraspState": "tool0.protocol.gripper",
    "Gripper": "tool0.api.gripper",
    "GripperResult": "tool0.protocol.goals",
    "GripperStep": "tool0.protocol.program",
    "GymUnavailableError": "tool0.errors",
    "InverseKinematics": "tool0.kinematics.inverse",
    "JointLimits": "tool0.description.model",
    "JointPeak": "tool0.api.dry_run",
    "JointSetpoint": "tool0.protocol.state",
    "JointValues": "tool0.api.robot",
    "JointsMotion": "tool0.protocol.trajectories",
    "KeepOut": "tool0.protocol.planning",
    "LimitsError": "tool0.errors",
    "LoopStep": "tool0.protocol.program",
    "ModelError": "tool0.errors",
    "MoveJointStep": "tool0.protocol.program",
    "MoveLinearStep": "tool0.protocol.program",
    "NamedPose": "tool0.description.named_pose",
    "NoSuchPartError": "tool0.errors",
    "NotOfferedError": "tool0.errors",
    "ObjectState": "tool0.description.scene_state",
    "Overran": "tool0.protocol.bus",
    "Panel": "tool0.panel.server",
    "ParallelGripper": "tool0.description.model",
    "Payload": "tool0.description.payload",
    "PenetrationError": "tool0.errors",
    "PickOptions": "tool0.cli.demos.hand",
    "PickReport": "tool0.cli.demos.report",
    "PlaceObjectStep": "tool0.protocol.program",
    "Plan": "tool0.protocol.planning",
    "PlanOptions": "tool0.api.arm",
    "PlanTarget": "tool0.protocol.planning",
    "PlanningError": "tool0.errors",
    "PolicyError": "tool0.errors",
    "Pose": "tool0.description.transform",
    "Program": "tool0.protocol.program",
    "ProgramCheck": "tool0.protocol.programs",
    "ProgramError": "tool0.errors",
    "ProgramHandle": "tool0.api.programs",
    "ProgramProblem": "tool0.protocol.programs",
    "ProgramRun": "tool0.protocol.programs",
    "ProgramState": "tool0.protocol.control_box_state",
    "Programs": "tool0.api.programs",
    "RecordedEvent": "tool0.recording.entries",
    "RecordedRequest": "tool0.recording.entries",
    "Recording": "tool0.api.recording",
    "RecordingError": "tool0.errors",
    "RecordingFile": "tool0.recording.reading",
    "RecordingStatus": "tool0.protocol.recordings",
    "RenderError": "tool0.errors",
    "RequestError": "tool0.errors",
    "Robot": "tool0.api.robot",
    "RobotDescription": "tool0.description.robot",
    "RobotMode": "tool0.protocol.control_box_state",
    "RobotModel": "tool0.description.model",
    "Ros1Bridge": "tool0.ros1.bridge",
    "Ros1Options": "tool0.ros1.options",
    "Ros2Node": "tool0.ros2.node",
    "Ros2Options": "tool0.ros2.options",
    "RosUnavailableError": "tool0.errors",
    "SafetyLimits": "tool0.protocol.control_box_state",
    "SafetyMode": "tool0.protocol.control_box_state",
    "SavedProgram": "tool0.protocol.programs",
    "SceneHandle": "tool0.api.scene",
    "SetOutputStep": "tool0.protocol.program",
    "SimulationConfig": "tool0.simulation.config",
    "SimulationInfo": "tool0.protocol.robot",
    "Snapshot": "tool0.protocol.state",
    "Solution": "tool0.description.posture",
    "SourceLocation": "tool0.errors",
    "Subscription": "tool0.protocol.bus",
    "Tolerance": "tool0.protocol.goals",
    "Tool0Error": "tool0.errors",
    "ToolPose": "tool0.protocol.program",
    "TouchReport": "tool0.api.dry_run",
    "TrajectoryPoint": "tool0.protocol.trajectories",
    "TrajectoryState": "tool0.protocol.trajectories",
    "Transform": "tool0.description.transform",
    "TransportError": "tool0.errors",
    "UnreachableError": "tool0.errors",
    "UntilStep": "tool0.protocol.program",
    "Upright": "tool0.protocol.planning",
    "UrArm": "tool0.ur.options",
    "UrController": "tool0.ur.process",
    "UrOptions": "tool0.ur.options",
    "UrReport": "tool0.protocol.control_box_state",
    "VideoWriter": "tool0.recording.video_writer",
    "WaitStep": "tool0.protocol.program",
    "WasReset": "tool0.protocol.bus",
    "WrenchReading": "tool0.protocol.sensors",
    "bringup": "tool0.api.bringup",
    "check": "tool0.lint.check",
    "connect": "tool0.api.connect",
    "encode_depth": "tool0.recording.png",
    "encode_png": "tool0.recording.png",
    "find_bin": "tool0.api.grasps",
    "open_recording": "tool0.recording.reading",
    "pick_and_place": "tool0.cli.demos.picker",
}


__version__: str


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("tool0")
    if name not in _HOMES:
        raise AttributeError(f"module 'tool0' has no attribute '{name}'")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
