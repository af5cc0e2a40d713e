"""``tool0.open_recording``: a recording as arrays, events and snapshots."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, final

import msgspec
import numpy as np
from numpy.typing import NDArray

from tool0.description.scene_state import Contact
from tool0.description.tool_poses import ToolPoses
from tool0.errors import RecordingError
from tool0.protocol.objects import ObjectInfo
from tool0.protocol.reproduction import Reproduction
from tool0.protocol.robot import DescriptionInfo, SimulationInfo
from tool0.recording.cdr import JointStates, Wrenches, decode_text
from tool0.recording.columns import columns_of
from tool0.recording.contents import (
    BRINGUP,
    DESCRIPTION,
    FORMAT,
    MESHES,
    METADATA,
    ROBOT,
    SIMULATION,
    RecordingInfo,
    info_from,
)
from tool0.recording.damage import damage, reads
from tool0.recording.entries import RecordedEvent, RecordedRequest
from tool0.recording.events import EVENTS
from tool0.recording.frames import (
    CONTACTS,
    GRIPPERS,
    JOINT_COMMANDS,
    JOINT_STATES,
    OBJECTS,
    STATE,
    contact_points,
    object_transforms,
)
from tool0.recording.journal import REQUESTS
from tool0.recording.parsing import Stream, parse
from tool0.recording.robot import RecordedRobot
from tool0.recording.snapshots import Snapshots, held
from tool0.recording.state import decode_change

if TYPE_CHECKING:
    import pandas as pd

    from tool0.description.robot import RobotDescription
    from tool0.protocol.state import Snapshot

T = TypeVar("T")
Array = NDArray[np.float64]


def open_recording(path: Path | str) -> RecordingFile:
    """Read a recording that tool0 wrote.

    If a crash or a full disk has truncated the file, it is read up to its last complete
    chunk.

    Args:
        path: Path of the MCAP file.

    Raises:
        RecordingError: If the file cannot be read, is damaged, or is not a recording.
    """
    return RecordingFile(Path(path))


@final
class RecordingFile:
    """A recording, with arrays that have one row per snapshot in time order."""

    def __init__(self, path: Path) -> None:
        """Read the file, or raise RecordingError."""
        self._path = path
        parsed = parse(path, JOINT_STATES)
        self._streams = parsed.streams
        self._is_complete = parsed.is_complete
        self._attachments = parsed.attachments
        self._meshes = parsed.metadata.get(MESHES, {})
        metadata = parsed.metadata.get(METADATA)
        if metadata is None:
            raise RecordingError(
                f"{path} is an MCAP file, but no recording of tool0: it has no "
                f"metadata '{METADATA}'"
            )
        if metadata.get("format") != str(FORMAT):
            raise RecordingError(
                f"{path} has format {metadata.get('format')}, and this version of "
                f"tool0 reads {FORMAT}; it was recorded with tool0 "
                f"{metadata.get('version', '(unknown)')}"
            )
        with damage(path, "metadata"):
            self._info = info_from(metadata)
        self._names = self._info.joint_names

    # ---- recorded data --------------------------------------------------------------

    @property
    def path(self) -> Path:
        """Path of the file."""
        return self._path

    @property
    def info(self) -> RecordingInfo:
        """Static content of the recording, such as version, engine and start time."""
        return self._info

    @property
    def is_complete(self) -> bool:
        """Whether the file was finished; otherwise, its end is missing."""
        return self._is_complete

    @property
    def attachments(self) -> Mapping[str, bytes]:
        """Attachments, which are files within the file, by name."""
        return self._attachments

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the arrays' columns."""
        return self._names

    def __len__(self) -> int:
        """Return the number of snapshots."""
        return len(self._stream(JOINT_STATES).times)

    @cached_property
    @reads(JOINT_STATES)
    def tick(self) -> NDArray[np.int64]:
        """Number of control periods since the start or the last reset, shape (n,)."""
        times = np.array(self._stream(JOINT_STATES).times, dtype=np.float64)
        return np.rint(times * 1e-9 / self.info.control_period).astype(np.int64)

    @cached_property
    def step(self) -> NDArray[np.int64]:
        """Number of control periods since the bring-up, across resets, shape (n,)."""
        return np.array(self._stream(JOINT_STATES).sequence, dtype=np.int64)

    @cached_property
    def time(self) -> Array:
        """Simulated time [s], shape (n,)."""
        return np.multiply(self.tick, self.info.control_period, dtype=np.float64)

    @property
    def duration(self) -> float:
        """Simulated time from the first snapshot to the last snapshot [s]."""
        return float(self.time[-1] - self.time[0]) if len(self) else 0.0

    @property
    def position(self) -> Array:
        """Measured positions [rad | m], shape (n, n_joints)."""
        return self._states[0]

    @property
    def velocity(self) -> Array:
        """Measured velocities [rad/s | m/s], shape (n, n_joints)."""
        return self._states[1]

    @property
    def effort(self) -> Array:
        """Applied efforts [N·m | N], shape (n, n_joints)."""
        return self._states[2]

    @property
    def desired_position(self) -> Array:
        """Desired positions [rad | m], shape (n, n_joints).

        A desired position is NaN if no controller has a position setpoint for the
        joint.
        """
        return self._commands[0]

    @property
    def desired_velocity(self) -> Array:
        """Desired velocities [rad/s | m/s], shape (n, n_joints).

        A desired velocity is NaN if no controller has a position setpoint for the
        joint.
        """
        return self._commands[1]

    @cached_property
    def tool_poses(self) -> Mapping[str, Array]:
        """Poses x, y, z [m], qw, qx, qy, qz in the root frame, shape (n, 7), by tool.

        A tool is the flange of an arm, such as ``tool0``, or the point midway between
        the pads of a gripper, such as ``gripper.tcp``.  The poses are computed from the
        measured joint positions.
        """
        return ToolPoses(self.robot.description.model, self._names).poses(self.position)

    @cached_property
    @reads(OBJECTS)
    def objects(self) -> Mapping[str, Array]:
        """Poses x, y, z [m], qw, qx, qy, qz in the root frame, shape (n, 7), by object.

        The pose of an object is NaN while the object does not exist.
        """
        stream = self._stream(OBJECTS)
        found: dict[str, Array] = {}
        scenes = self._scene_names
        first = 0
        while first < len(stream.frames):
            names = scenes[stream.frames[first]]
            last = first
            while last < len(stream.frames) and scenes[stream.frames[last]] is names:
                last += 1
            layout = object_transforms(self.info.root, names)
            poses = layout.arrays(stream.messages[first:last])
            for name, values in zip(names, poses, strict=True):
                array = found.setdefault(name, np.full((len(self), 7), math.nan))
                array[stream.frames[first:last]] = values[:, (0, 1, 2, 6, 3, 4, 5)]
            first = last
        return found

    @cached_property
    @reads("wrenches")
    def wrenches(self) -> Mapping[str, Array]:
        """Forces [N] and torques [N·m] at the flange, in its axes, (n, 6), by arm.

        Wrenches are sampled less often than joints.  Each sample is held until the next
        sample.
        """
        found = {}
        for arm, (topic, flange) in self.robot.wrench_topics.items():
            stream = self._streams.get(topic)
            if stream is not None:
                values = Wrenches(flange).arrays(stream.messages)
                found[arm] = held(values, stream.frames, len(self))
        return found

    @cached_property
    @reads(GRIPPERS)
    def gripper_states(self) -> Mapping[str, Array]:
        """Opening [m], opening rate [m/s] and force [N], shape (n, 3), by gripper."""
        stream, names = self._stream(GRIPPERS), list(self.robot.grippers)
        values = np.stack(JointStates(names).arrays(stream.messages), axis=2)
        found = {}
        for i, name in enumerate(names):
            array = np.full((len(self), 3), math.nan)
            array[stream.frames] = values[:, i]
            found[name] = array
        return found

    @cached_property
    @reads(CONTACTS)
    def contacts(self) -> Sequence[tuple[Contact, ...]]:
        """Contacts of each snapshot with their forces [N], in the root's axes.

        Each sample is held until the next sample.
        """
        layout, stream = contact_points(self.info.root), self._stream(CONTACTS)
        found: list[tuple[Contact, ...]] = []
        bodies: Sequence[str] = ()
        changes = self._changes
        last: tuple[Contact, ...] = ()
        for frame, message in zip(stream.frames, stream.messages, strict=True):
            found += [last] * (frame - len(found))
            bodies = changes.get(frame, {}).get("bodies", bodies)
            last = tuple(
                Contact(
                    bodies[point[9]],
                    bodies[point[10]],
                    point[0:3],
                    point[3:6],
                    point[6:9],
                )
                for point in layout.decode(message)
            )
        return found + [last] * (len(self) - len(found))

    @cached_property
    def events(self) -> Sequence[RecordedEvent]:
        """Events, in file order."""
        return self._texts(EVENTS, RecordedEvent)

    @cached_property
    def requests(self) -> Sequence[RecordedRequest]:
        """Requests since the bring-up that changed the simulation."""
        return self._texts(REQUESTS, RecordedRequest)

    @property
    def gripping(self) -> Iterator[tuple[int, tuple[str, ...]]]:
        """Changes of the grippers that hold an object by pressing on it from two sides.

        Each change consists of the number of a snapshot and the grippers that hold an
        object from this snapshot until the next change.
        """
        for frame, fields in self._changes.items():
            if "gripping" in fields:
                yield frame, fields["gripping"]

    # ---- the robot ------------------------------------------------------------------

    @cached_property
    def robot(self) -> RecordedRobot:
        """The robot's description and meshes at the time of recording."""
        return RecordedRobot(
            self.path,
            self._meshes,
            self._decoded(DESCRIPTION, DescriptionInfo),
            self.attachments,
        )

    @property
    @reads(ROBOT)
    def urdf(self) -> str:
        """The robot as one recorded URDF document."""
        return self._attached(ROBOT).decode()

    @property
    def description(self) -> RobotDescription:
        """The robot, with the recorded meshes."""
        return self.robot.description

    @cached_property
    def simulation(self) -> SimulationInfo:
        """Constant properties of the simulation during the recording."""
        return self._decoded(SIMULATION, SimulationInfo)

    @cached_property
    def bringup(self) -> Reproduction:
        """All data that is needed to bring up the same robot again."""
        return self._decoded(BRINGUP, Reproduction)

    # ---- snapshots ------------------------------------------------------------------

    def snapshots(self) -> Sequence[Snapshot]:
        """Return all snapshots; each snapshot is created on access."""
        return self._snapshots

    # ---- tables ---------------------------------------------------------------------

    def to_pandas(self) -> pd.DataFrame:
        """Return the columns of ``table`` as a data frame with the index ``time`` [s].

        Raises:
            RecordingError: If pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            raise RecordingError(
                "to_pandas needs pandas, which is not installed: pip install pandas"
            ) from None
        index = pd.Index(self.time, name="time")
        return pd.DataFrame(self.table(), index=index)

    def table(self) -> dict[str, Array]:
        """Return all columns except time by name, such as ``elbow_joint.effort``.

        The columns of ``tool_poses`` are ``tool0.x`` to ``tool0.qz`` for a flange, and
        ``gripper.tcp.x`` to ``gripper.tcp.qz`` for the point midway between the pads of
        a gripper.  The columns of objects are ``NAME.x`` to ``NAME.qz``.  The columns
        of wrenches are ``ARM.fx`` to ``ARM.tz``.  The columns of grippers are
        ``NAME.opening``, ``NAME.speed`` and ``NAME.force``.
        """
        return columns_of(self)

    # ---- details --------------------------------------------------------------------

    def _stream(self, topic: str) -> Stream:
        return self._streams.get(topic) or Stream(topic, "")

    @cached_property
    @reads("snapshots")
    def _snapshots(self) -> Snapshots:
        return Snapshots(self, self._changes)

    @cached_property
    @reads(JOINT_STATES)
    def _states(self) -> tuple[Array, Array, Array]:
        return JointStates(self._names).arrays(self._stream(JOINT_STATES).messages)

    @cached_property
    @reads(JOINT_COMMANDS)
    def _commands(self) -> tuple[Array, Array]:
        stream = self._stream(JOINT_COMMANDS)
        layout = JointStates(self._names, has_effort=False)
        found = []
        for values in layout.arrays(stream.messages)[:2]:
            array = np.full((len(self), len(self._names)), math.nan)
            array[stream.frames] = values
            found.append(array)
        return found[0], found[1]

    @cached_property
    @reads(STATE)
    def _changes(self) -> Mapping[int, Mapping[str, Any]]:
        """Changed fields of the snapshots, by frame number."""
        stream = self._stream(STATE)
        pairs = zip(stream.frames, stream.messages, strict=True)
        return {frame: decode_change(decode_text(text)) for frame, text in pairs}

    @cached_property
    def _scene_names(self) -> Sequence[tuple[str, ...]]:
        """Names of the existing objects at each frame."""
        found: list[tuple[str, ...]] = []
        names: tuple[str, ...] = ()
        for frame in range(len(self)):
            scene: Sequence[ObjectInfo] | None = self._changes.get(frame, {}).get(
                "scene"
            )
            if scene is not None:
                names = tuple(item.name for item in scene)
            found.append(names)
        return found

    def _texts(self, topic: str, kind: type[T]) -> list[T]:
        """Return the decoded JSON messages of a topic."""
        with damage(self.path, topic):
            return [
                msgspec.json.decode(decode_text(text), type=kind)
                for text in self._stream(topic).messages
            ]

    def _decoded(self, name: str, kind: type[T]) -> T:
        """Return the decoded content of a JSON attachment."""
        with damage(self.path, name):
            return msgspec.json.decode(self._attached(name), type=kind)

    def _attached(self, name: str) -> bytes:
        try:
            return self.attachments[name]
        except KeyError:
            raise RecordingError(
                f"{self.path} lacks its attachment '{name}': it was cut off too early"
            ) from None
