"""The view of a running simulation in the panel."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar, cast, final

from msgspec import structs

from tool0.description.camera import Camera
from tool0.description.model import Joint, JointType
from tool0.description.parts import find_grippers
from tool0.description.poses import PoseStore
from tool0.panel.frames import frame_of, rounded
from tool0.panel.notices import EventWatcher
from tool0.panel.protocol import (
    ControllerInfo,
    ControllerStage,
    GripperState,
    RecordingInfo,
    StallInfo,
    Status,
    ViewInfo,
    ViewScene,
)
from tool0.panel.robot_info import (
    RobotFiles,
    camera_infos,
    object_info,
    pose_infos,
    robot_info,
)
from tool0.protocol.backend import Backend, missing_methods
from tool0.protocol.controllers import ControllerStatus, Role
from tool0.protocol.episodes import EpisodesStatus, ReadEpisodes
from tool0.protocol.gripper import GraspState
from tool0.protocol.notifications import Notification
from tool0.protocol.programs import ProgramRun, ReadRuns
from tool0.protocol.recordings import ReadRecording, RecordingStatus
from tool0.protocol.request import Request
from tool0.protocol.robot import ReadInfo, SimulationInfo
from tool0.protocol.sensors import ListCameras
from tool0.sensing.grasp import GraspDetector

if TYPE_CHECKING:
    from tool0.description.scene import SceneObject
    from tool0.protocol.bus import Subscription
    from tool0.protocol.state import Snapshot
    from tool0.protocol.state_message import StateMessage

R = TypeVar("R")


@final
class SimulationView:
    """Source of frames and statuses of a simulation; see ``view_feed.ViewSource``."""

    def __init__(self, backend: Backend) -> None:
        """Observe a backend whose field ``states`` is not None."""
        states = backend.states
        assert states is not None
        self._backend, self._states = backend, states
        description = states.description
        info: SimulationInfo = backend.answer(ReadInfo())
        self.files = RobotFiles(description)
        first = states.snapshot
        limits = {name: found.limits for name, found in info.joint_limits.items()}
        self.info = ViewInfo(
            mode=backend.mode,
            engine=info.engine,
            control_period=info.control_period,
            grasp_assist=info.grasp_assist,
            robot=robot_info(description, first.joint_names, info.ground, limits),
            cameras=camera_infos(self._cameras()),
            notices=[],
            missing=missing_methods(backend),
        )
        self.cameras = states.cameras
        self._joints = {
            name: replace(joint, limits=limits.get(name, joint.limits))
            for name, joint in description.model.joint_by_name.items()
        }
        self._seen: Snapshot | None = None
        self._objects = first.scene
        self._scene = self._scene_of(0, first.scene)
        self._frame = frame_of(first, self._scene.number)
        self._info = info
        self._poses = PoseStore(description)
        self._watcher = EventWatcher(states, info.warnings)
        self._grasps = {
            name: GraspDetector(gripper)
            for name, gripper in find_grippers(description.model).items()
        }
        self._grippers: list[GripperState] = []
        self._forces: Subscription | None = None
        """Subscription that adds the required forces to snapshots."""
        self._has_contacts = self._has_wrenches = False

    def scene(self) -> ViewScene:
        return self._scene

    def frame(self) -> StateMessage:
        snapshot = self._states.snapshot
        if snapshot is not self._seen:
            self._seen = snapshot
            self._grippers = [
                gripper_state(name, detector.observe(snapshot))
                for name, detector in self._grasps.items()
            ]
            if snapshot.scene is not self._objects:
                self._objects = snapshot.scene
                self._scene = self._scene_of(self._scene.number + 1, snapshot.scene)
            frame = frame_of(
                snapshot,
                self._scene.number,
                contacts=self._has_contacts,
                wrenches=self._has_wrenches,
            )
            if frame != self._frame:
                self._frame = frame
        return self._frame

    def need_forces(self, *, contacts: bool, wrenches: bool) -> None:
        if (contacts, wrenches) == (self._has_contacts, self._has_wrenches):
            return
        self._has_contacts, self._has_wrenches = contacts, wrenches
        before, self._forces = self._forces, None
        if contacts or wrenches:
            self._forces = self._states.subscribe(
                with_contacts=contacts, with_arms=wrenches, latest_only=True
            )
            self._states.refresh()
        if before is not None:
            before.close()
        self._seen = None

    def status(self, clients: int) -> Status:
        self.frame()  # updates the states of the grippers
        snapshot = self._states.snapshot
        return Status(
            paused=snapshot.is_paused,
            stopped=snapshot.is_stopped,
            fault=snapshot.fault,
            speed=snapshot.speed,
            real_time_factor=round(snapshot.real_time_factor, 2),
            late_ticks=snapshot.late_ticks,
            clients=clients,
            controllers=controller_infos(
                self._info.defined_controllers,
                snapshot.controllers,
                self._joints,
                self._info.controller_roles,
            ),
            grippers=self._grippers,
            poses=pose_infos(self._poses, self._watcher.report_once),
            stalls=stall_infos(snapshot),
            targets=targets_of(snapshot),
            control_boxes=list(snapshot.control_boxes),
            recording=_recording_info(self._ask(ReadRecording(), None)),
            programs=list(self._runs()),
            episodes=self._episodes(),
        )

    def _ask(self, request: Request[R], default: R) -> R:
        """Return the response, or ``default`` if the request is not supported."""
        if self._backend.why_missing(type(request)):
            return default
        response: R = self._backend.answer(request)
        return response

    def _cameras(self) -> tuple[Camera, ...]:
        return self._ask(ListCameras(), ())

    def _runs(self) -> tuple[ProgramRun, ...]:
        return self._ask(ReadRuns(), ())

    def _episodes(self) -> EpisodesStatus | None:
        """Return the demonstrations' state, which changes at most once per second."""
        found = self._ask(ReadEpisodes(), None)
        if found is None:
            return None
        return structs.replace(found, duration=float(int(found.duration)))

    def notifications(self) -> Sequence[Notification]:
        return self._watcher.notifications()

    def close(self) -> None:
        self.need_forces(contacts=False, wrenches=False)
        self._watcher.close()

    def _scene_of(self, number: int, objects: Sequence[SceneObject]) -> ViewScene:
        self.files.set_objects(objects)
        infos = [object_info(item, self.files) for item in objects]
        return ViewScene(number=number, objects=infos)


def gripper_state(name: str, grasp: GraspState) -> GripperState:
    """Return a gripper's state in the form that the protocol uses."""
    return GripperState(
        name=name,
        opening=round(grasp.opening, 4),
        motion=grasp.motion,
        gobj=grasp.gobj,
        width=None if grasp.width is None else round(grasp.width, 4),
    )


def stall_infos(snapshot: Snapshot) -> list[StallInfo]:
    """Return the joints at their effort limit, in the form that the protocol uses."""
    return [
        StallInfo(
            joint=stall.joint,
            effort=round(stall.effort, 1),
            contacts=list(stall.contacts),
        )
        for stall in snapshot.stalls
    ]


def targets_of(snapshot: Snapshot) -> dict[str, float]:
    """Return the target positions of the joints' motions [rad | m]."""
    return {
        joint: rounded(setpoint.target)
        for joint, setpoint in snapshot.setpoints().items()
    }


def controller_infos(
    defined: Mapping[str, str],
    loaded: Sequence[ControllerStatus],
    joints: Mapping[str, Joint],
    roles: Mapping[str, Role],
) -> list[ControllerInfo]:
    """Return the controllers, starting with those of the YAML file in file order.

    Args:
        defined: Types of the controllers in the YAML file, by name.
        loaded: Loaded controllers.
        joints: The robot's joints, with their limits.
        roles: Roles of the controllers in the YAML file, by name.
    """
    status_of = {status.name: status for status in loaded}
    types = {**defined, **{status.name: status.type for status in loaded}}
    infos = []
    for name, kind in types.items():
        status = status_of.get(name)
        role = roles[name] if status is None else status.role
        claims = () if status is None else status.claimed
        claimed = [joint for _, names in claims for joint in names]
        infos.append(
            ControllerInfo(
                name=name,
                type=kind,
                state="unloaded"
                if status is None
                else cast(ControllerStage, status.state),
                is_running=status is not None and status.is_running,
                role=role,
                interface=claims[0][0] if claims else None,
                joints=claimed,
                undrivable=_obstacle(
                    kind, role, status, [joints[item] for item in claimed]
                ),
            )
        )
    return infos


def _obstacle(
    kind: str, role: Role, status: ControllerStatus | None, joints: Sequence[Joint]
) -> str | None:
    """Return the reason why sliders cannot move a controller's joints, or None."""
    if role is Role.READER:
        return "It moves no joints."
    if role is not Role.TRAJECTORY:
        name = kind.rpartition("/")[2]
        return f"Sliders drive a JointTrajectoryController; this is a {name}."
    if status is None:
        return "It is not loaded: load and start it."
    if not status.is_running:
        remedy = status.blocked or "start it"
        return f"It is {status.state}: {remedy}."
    for joint in joints:
        is_limited = math.isfinite(joint.limits.upper - joint.limits.lower)
        if joint.type is not JointType.CONTINUOUS and not is_limited:
            return (
                f"Joint '{joint.name}' has no position limits, so a slider has no ends."
            )
    return None


def _recording_info(status: RecordingStatus | None) -> RecordingInfo | None:
    if status is None:
        return None
    return RecordingInfo(
        file=status.file,
        is_recording=status.is_recording,
        seconds=int(status.duration),
        size=status.size // 10_000 * 10_000,
        dropped=status.dropped,
        error=status.error,
    )
