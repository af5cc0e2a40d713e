"""Observers of a demo: measurements of the grip, and frames of a video."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, final

from tool0.api.scene import object_pose
from tool0.description.forward_kinematics import link_poses
from tool0.description.grasp_frames import pad_links
from tool0.description.transform import Transform, Vector3
from tool0.errors import ControlError, EngineError
from tool0.protocol.state import SNAPSHOT_PERIOD, Snapshot

if TYPE_CHECKING:
    from tool0.api.gripper import Gripper
    from tool0.api.robot import Robot

FRAME_RATE = 30
"""Frames per simulated second [Hz]."""
_POLL_PERIOD = 0.5
"""Longest wait for a snapshot [wall s]; a pause is detected after this time."""
_TIME_ROUNDING = 1e-9  # tolerance [s]


class _Held(NamedTuple):
    """An object between the pads of a gripper."""

    base: str
    """The link that carries the fingers."""
    pads: tuple[str, str]
    start: Vector3
    """Start position of the object relative to the middle of the pads, in ``base``
    [m]."""


@final
class GraspMonitor:
    """Advances simulated time, and takes measurements from every snapshot."""

    def __init__(
        self,
        robot: Robot,
        item: str,
        on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
    ) -> None:
        """Start measuring the effect of the grippers on the object ``item``.

        Args:
            robot: The robot.
            item: The name of an object in the robot's scene.
            on_snapshot: Called with each snapshot, for recording.
        """
        self._robot = robot
        self.item = item
        self._on_snapshot = on_snapshot
        self._subscription = robot.subscribe()
        model = robot.description.model
        self._pads = {
            name: pad_links(model, gripper.geometry)
            for name, gripper in robot.grippers.items()
        }
        self._held: _Held | None = None
        self.slip: float | None = None
        """Largest slip of the object between the pads [m]; None before the first
        measurement."""
        self.peak_force = 0.0
        """Largest measured force of a pad on the object [N]."""
        self.phases: dict[str, float] = {}
        """Phase → duration of the phase [simulated s]."""
        self._phase = ""
        self._since = robot.time

    def begin(self, phase: str) -> None:
        """End the current phase, and begin ``phase``."""
        now = self._robot.time
        if self._phase:
            self.phases[self._phase] = self.phases.get(self._phase, 0.0) + (
                now - self._since
            )
        self._phase, self._since = phase, now

    @property
    def phase(self) -> str:
        """The current phase."""
        return self._phase

    def until(self, done: Callable[[], bool], timeout: float) -> bool:
        """Wait until ``done()`` is true; return False on a timeout.

        Args:
            done: Called after each snapshot.
            timeout: Longest wait [simulated s].

        Raises:
            ControlError: If the object is removed, or if a robot that does not run in
                real time is paused.
            EngineError: If the physics failed.
        """
        end = self._robot.time + timeout
        while not done():
            if self._robot.time >= end:
                return False
            self._advance()
        return True

    def wait(self, duration: float) -> None:
        """Wait for ``duration`` [simulated s]."""
        self.until(lambda: False, duration)

    def start_slip(self, gripper: Gripper) -> None:
        """Start measuring the object's slip relative to its present position."""
        geometry = gripper.geometry
        base = self._robot.description.model.joint(geometry.joint).parent
        pads = pad_links(self._robot.description.model, geometry)
        start = self._held_at(self._robot.snapshot, base, pads)
        self._held = _Held(base, pads, start)
        self.slip = self.slip or 0.0

    def stop_slip(self) -> None:
        """Stop measuring slip."""
        self._held = None

    def pose(self) -> Transform:
        """Return the object's pose in the root frame."""
        return self._robot.scene.pose(self.item)

    def pad_force(self) -> float:
        """Return the largest force between a pad and the object [N]."""
        item, pads = self.item, set(itertools.chain(*self._pads.values()))
        return max(
            (
                math.hypot(*contact.force)
                for contact in self._robot.contacts()
                if (contact.first == item and contact.second in pads)
                or (contact.second == item and contact.first in pads)
            ),
            default=0.0,
        )

    def close(self) -> None:
        """End the subscription."""
        self._subscription.close()

    def _advance(self) -> None:
        robot = self._robot
        if not robot.is_realtime:
            robot.run(max(SNAPSHOT_PERIOD, robot.control_period))
        snapshot = self._subscription.following(_POLL_PERIOD)
        while snapshot is not None:
            self._measure(snapshot)
            snapshot = self._subscription.following(0.0)
        self.peak_force = max(self.peak_force, self.pad_force())

    def _measure(self, snapshot: Snapshot) -> None:
        if snapshot.fault is not None:
            raise EngineError(snapshot.fault)
        if self.item not in {item.name for item in snapshot.scene}:
            raise ControlError(f"the object '{self.item}' is gone")
        self._on_snapshot(snapshot)
        if (held := self._held) is not None and self.slip is not None:
            now = self._held_at(snapshot, held.base, held.pads)
            self.slip = max(self.slip, math.dist(held.start, now))

    def _held_at(self, snapshot: Snapshot, base: str, pads: tuple[str, str]) -> Vector3:
        """Return the object's position relative to the pads' middle, in ``base``."""
        position = dict(zip(snapshot.joint_names, snapshot.position, strict=True))
        found = link_poses(self._robot.description.model, position)
        (ax, ay, az), (bx, by, bz) = (found[pad].position for pad in pads)
        middle = Transform(
            position=((ax + bx) / 2.0, (ay + by) / 2.0, (az + bz) / 2.0),
            rotation=found[base].rotation,
        )
        return middle.inverse().apply(object_pose(snapshot, self.item).position)


@final
class FrameRecorder:
    """Records the snapshots of a demo for the frames of a video.

    Rendering takes longer than the simulation.  Therefore, the frames are rendered
    after the demo.
    """

    def __init__(self, rate: int = FRAME_RATE) -> None:
        """Record ``rate`` frames per simulated second [Hz]."""
        self._rate = rate
        self._due: float | None = None  # time of the next frame [simulated s]
        self.frames: list[Snapshot] = []
        """The recorded snapshots, in chronological order."""

    def record(self, snapshot: Snapshot) -> None:
        """Keep a snapshot if the next frame is due."""
        period = 1.0 / self._rate
        due = snapshot.time if self._due is None else self._due
        if abs(snapshot.time - due) > period + _TIME_ROUNDING:
            # After a reset or a gap in the snapshots, the video has a cut.
            due = snapshot.time
        if snapshot.time >= due - _TIME_ROUNDING:
            self.frames.append(snapshot)
            due += period
        self._due = due

    def write(
        self,
        path: Path,
        robot: Robot,
        camera: str,
        progress: Callable[[str, float], None],
    ) -> None:
        """Render the recorded snapshots with ``camera``, and write them to an MP4 file.

        Args:
            path: The file to write; an existing file is replaced.
            robot: The robot that was recorded.
            camera: One of the robot's cameras.
            progress: Called with the activity and the completed fraction.

        Raises:
            ConfigError: If the file cannot be written.
            RenderError: If this machine cannot render or encode the video.
        """
        from tool0.recording.video_writer import VideoWriter

        view = robot.camera(camera)
        size = view.camera
        activity = f"writing {path.name}"
        with VideoWriter(path, size.width, size.height, self._rate) as video:
            for number, snapshot in enumerate(self.frames):
                progress(activity, number / len(self.frames))
                video.write(view.image(snapshot).rgb)
        progress(activity, 1.0)
