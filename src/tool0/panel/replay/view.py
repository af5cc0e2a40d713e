"""A recording, which the pages of ``tool0 replay`` play with the recorded robot."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, final

from tool0.description.model import JointLimits
from tool0.description.parts import find_grippers
from tool0.errors import RecordingError
from tool0.panel.frames import frame_of
from tool0.panel.protocol import (
    GripperState,
    ReplayInfo,
    Status,
    ViewInfo,
    ViewScene,
)
from tool0.panel.replay.notices import notices_of
from tool0.panel.replay.playhead import Playhead
from tool0.panel.robot_info import RobotFiles, camera_infos, object_info, robot_info
from tool0.panel.simulation_view import (
    controller_infos,
    gripper_state,
    stall_infos,
    targets_of,
)
from tool0.protocol.backend import missing_methods
from tool0.protocol.notifications import Notification
from tool0.protocol.replay import LoopReplay, ReadReplay, ReplaySamples, SeekReplay
from tool0.protocol.request import Request
from tool0.protocol.robot import LimitsInfo
from tool0.protocol.running import Pause, Reset, Resume, SetSpeed, Step
from tool0.recording.signals import Signals, thinned
from tool0.recording.video import cameras_of
from tool0.sensing.grasp import SHORT_OF_IT, judge

if TYPE_CHECKING:
    from tool0.description.scene import SceneObject
    from tool0.protocol.state_message import StateMessage
    from tool0.recording.reading import RecordingFile
    from tool0.recording.simulated_run import SimulatedRun


@final
class Replay:
    """A recording and its playhead, which all pages share.

    This class is both the server's backend and the source of the view.
    """

    mode: Final = "replay"
    states: Final = None

    def __init__(
        self, recording: RecordingFile, beside: SimulatedRun | None = None
    ) -> None:
        """Start with a paused playback; raise RecordingError if there are no snapshots.

        ``beside`` is a simulated run that is plotted next to the recording.
        """
        if len(recording) == 0:
            raise RecordingError(f"{recording.path} has no snapshots to show")
        self._recording = recording
        self._times: list[float] = recording.time.tolist()
        self._snapshots = recording.snapshots()
        self.playhead = Playhead(self._times[0], self._times[-1])
        self._signals = Signals(recording, beside)
        description = recording.description
        limits = {
            name: _limits(info)
            for name, info in recording.simulation.joint_limits.items()
        }
        self._joints = {
            name: replace(joint, limits=limits.get(name, joint.limits))
            for name, joint in description.model.joint_by_name.items()
        }
        self._grippers = find_grippers(description.model)
        self.files = RobotFiles(description)
        self.info = ViewInfo(
            mode="replay",
            engine=recording.info.engine,
            control_period=recording.info.control_period,
            grasp_assist=recording.simulation.grasp_assist,
            robot=robot_info(
                description, recording.joint_names, recording.simulation.ground, limits
            ),
            cameras=camera_infos(recording.bringup.cameras),
            notices=notices_of(recording),
            missing=missing_methods(self),
            replay=ReplayInfo(
                file=recording.path.name,
                start=self._times[0],
                end=self._times[-1],
                is_complete=recording.is_complete,
                signals=list(self._signals),
            ),
        )
        self.cameras = cameras_of(recording, lambda: self._snapshots[self._index()])
        self._has_contacts = self._has_wrenches = False
        self._shown = -1
        snapshot = self._snapshots[0]
        self._objects = snapshot.scene
        self._scene = self._scene_of(0, snapshot.scene)
        self._frame = self.frame()

    # ---- view for pages, used in the server's thread ---------------------------------

    def scene(self) -> ViewScene:
        return self._scene

    def frame(self) -> StateMessage:
        index = self._index()
        if index != self._shown:
            self._shown = index
            snapshot = self._snapshots[index]
            if snapshot.scene is not self._objects:
                self._objects = snapshot.scene
                self._scene = self._scene_of(self._scene.number + 1, snapshot.scene)
            self._frame = frame_of(
                snapshot,
                self._scene.number,
                contacts=self._has_contacts,
                wrenches=self._has_wrenches,
            )
        return self._frame

    def need_forces(self, *, contacts: bool, wrenches: bool) -> None:
        if (contacts, wrenches) != (self._has_contacts, self._has_wrenches):
            self._has_contacts, self._has_wrenches = contacts, wrenches
            self._shown = -1

    def status(self, clients: int) -> Status:
        index = self._index()
        snapshot = self._snapshots[index]
        return Status(
            paused=not self.playhead.is_playing,
            stopped=snapshot.is_stopped,
            fault=snapshot.fault,
            speed=self.playhead.speed,
            real_time_factor=round(snapshot.real_time_factor, 2),
            late_ticks=snapshot.late_ticks,
            clients=clients,
            controllers=controller_infos({}, snapshot.controllers, self._joints, {}),
            grippers=self._gripper_states(index),
            poses=[],
            stalls=stall_infos(snapshot),
            targets=targets_of(snapshot),
            control_boxes=list(snapshot.control_boxes),
            programs=[],
            loops=self.playhead.loops,
        )

    def notifications(self) -> Sequence[Notification]:
        return ()  # pages have all notices

    def close(self) -> None:
        self.cameras.close()

    # ---- requests --------------------------------------------------------------------

    def post(
        self, request: Request[Any], when_failed: Callable[[Exception], None]
    ) -> None:
        """Do nothing, because streams are not supported."""

    def check_setpoint(self, request: Request[Any]) -> None:
        """Do nothing, because streams are not supported."""

    def superseded(self, request: Request[Any]) -> Collection[str]:
        return ()

    def why_missing(self, request: type[Request[Any]]) -> str:
        return "" if issubclass(request, _OFFERED) else _ONLY_SHOWS

    def answer(self, request: Request[Any]) -> Any:
        playhead = self.playhead
        match request:
            case Resume():
                playhead.play()
            case Pause():
                playhead.pause()
            case SetSpeed(factor=factor):
                playhead.set_speed(factor)
            case LoopReplay(loops=loops):
                playhead.set_loops(loops)
            case SeekReplay(time=time):
                playhead.seek(time)
            case ReadReplay():
                return self._read(request)
            case Reset():
                playhead.seek(self._times[0])
            case Step(ticks=ticks):
                assert self.info.control_period is not None
                playhead.seek(playhead.time + ticks * self.info.control_period)
                return playhead.time
        return None

    # ---- details ---------------------------------------------------------------------

    def _index(self) -> int:
        """Return the index of the last snapshot at or before the playhead."""
        # A time that was received as text may be rounded.
        return max(0, bisect_right(self._times, self.playhead.time + 1e-9) - 1)

    def _read(self, request: ReadReplay) -> ReplaySamples:
        """Return the samples in a range, and the nearest sample beyond each end."""
        first = max(0, bisect_right(self._times, request.start) - 1)
        end = bisect_right(self._times, request.end) + 1
        columns = [self._signals[name][first:end] for name in request.signals]
        time = self._recording.time[first:end]
        times, values = thinned(time, columns, request.points)
        return ReplaySamples(times=times, values=values)

    def _gripper_states(self, index: int) -> list[GripperState]:
        first = bisect_right(self._times, self._times[index] - SHORT_OF_IT) - 1
        recent = self._snapshots[max(0, first) : index + 1]
        return [
            gripper_state(name, judge(gripper, recent))
            for name, gripper in self._grippers.items()
        ]

    def _scene_of(self, number: int, objects: Sequence[SceneObject]) -> ViewScene:
        self.files.set_objects(objects)
        return ViewScene(
            number=number, objects=[object_info(item, self.files) for item in objects]
        )


def _limits(info: LimitsInfo) -> JointLimits:
    return JointLimits(
        lower=-math.inf if info.lower is None else info.lower,
        upper=math.inf if info.upper is None else info.upper,
        velocity=math.inf if info.velocity is None else info.velocity,
        effort=math.inf if info.effort is None else info.effort,
    )


_OFFERED: Final = (
    *(Resume, Pause, SetSpeed, LoopReplay, SeekReplay, ReadReplay, Reset, Step),
)
_ONLY_SHOWS: Final = (
    "a replay only shows what was recorded; bring the robot up with `tool0 bringup`"
)
