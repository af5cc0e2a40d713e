"""Writes snapshots to one file as ROS 2 messages."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, final

from tool0.description.camera import Camera
from tool0.description.model import Joint, JointType, RobotModel
from tool0.description.parts import find_grippers, flange_names
from tool0.description.scene import SceneObject
from tool0.description.transform import to_transform
from tool0.protocol.state import JointSetpoint, Snapshot
from tool0.recording.cdr import JointStates, Points, Transforms, Wrenches, encode_text
from tool0.recording.contents import attach_meshes, object_meshes
from tool0.recording.mcap_file import McapFile
from tool0.recording.message_types import JOINT_STATE, POINTS, TEXT, TRANSFORMS, WRENCH
from tool0.recording.state import Derived, encode_change

JOINT_STATES: Final = "/joint_states"
JOINT_COMMANDS: Final = "/joint_commands"
GRIPPERS: Final = "/gripper_states"
DESCRIPTION: Final = "/robot_description"
CONTACTS: Final = "/contacts"
OBJECTS: Final = "/objects"
STATE: Final = "/tool0/state"
TF_PERIOD: Final = 0.032
"""Simulated time between two messages on ``/tf`` [s]."""
_FIRST_OBJECT: Final = 1000
"""Number of the first attached mesh of an object.  The robot's meshes have lower
numbers."""
_NAN: Final = math.nan
_NO_SETPOINT: Final = JointSetpoint(_NAN, _NAN, _NAN)
_ROUNDING: Final = 1e-6  # [s]


def wrench_topics(model: RobotModel) -> dict[str, str]:
    """Return the topic of the wrench at each arm's flange, by arm."""
    names = flange_names(model)
    if len(names) == 1:
        return dict.fromkeys(names, "/wrench")
    return {name: f"/{name}/wrench" for name in names}


def stamp(time: float) -> int:
    """Return a simulated time [s] in nanoseconds."""
    return round(time * 1e9)


@final
class FrameWriter:
    """Writer of consecutive snapshots to one file."""

    def __init__(
        self, file: McapFile, model: RobotModel, joint_names: Sequence[str]
    ) -> None:
        self._file = file
        self._model = model
        self._root = model.root
        self._states = JointStates(joint_names)
        self._commands = JointStates(joint_names, has_effort=False)
        topics, flanges = wrench_topics(model), flange_names(model)
        self._wrenches = {
            arm: (topics[arm], Wrenches(flange)) for arm, flange in flanges.items()
        }
        self._joints = [_JointFrame(joint) for joint in model.movable_joints]
        self._frames = Transforms([joint.frames for joint in self._joints])
        self._order = [
            joint_names.index(joint.name) if joint.name in joint_names else None
            for joint in self._joints
        ]
        self._grippers = [
            (joint_names.index(gripper.joint), gripper)
            for gripper in find_grippers(model).values()
        ]
        self._gripper_states = JointStates(list(find_grippers(model)))
        self._contacts = contact_points(self._root)
        self._bodies: dict[str, int] = {}
        """Numbers in ``/contacts`` of the links and objects that touched another body,
        by name."""
        self._next_frames = -math.inf
        self._had_contacts = False
        self._before: Snapshot | None = None
        self._derived = Derived()
        self._scene: tuple[SceneObject, ...] = ()
        self._meshes: dict[str, Path] = {}
        """Mesh files of objects that have already been attached."""
        self._objects = Transforms([])

    def write_robot(
        self, urdf: str, cameras: Mapping[str, Camera], time: float
    ) -> None:
        """Add the description and the static frames at ``time`` [s]."""
        at = stamp(time)
        self._file.write(DESCRIPTION, TEXT, at, encode_text(urdf.encode()))
        joints = [_JointFrame(joint) for joint in self._model.joints]
        fixed = [joint for joint in joints if not joint.is_movable]
        frames = [joint.frames for joint in fixed]
        poses = [joint.pose(0.0) for joint in fixed]
        for name, camera in cameras.items():
            frames.append((camera.link or self._root, optical_frame(name)))
            pose = to_transform(camera.pose)
            w, x, y, z = pose.quat_wxyz
            poses.append((*pose.position, x, y, z, w))
        data = Transforms(frames).encode(at, poses)
        self._file.write("/tf_static", TRANSFORMS, at, data)

    def write(self, snapshot: Snapshot) -> None:
        """Add the messages of one snapshot, starting with ``/joint_states``.

        The sequence number of each message is the snapshot's step.
        """
        file, time, step = self._file, stamp(snapshot.time), snapshot.step
        data = self._states.encode(
            time, snapshot.position, snapshot.velocity, snapshot.effort
        )
        file.write(JOINT_STATES, JOINT_STATE, time, data, step)
        setpoints = snapshot.setpoints()
        wanted = [setpoints.get(name, _NO_SETPOINT) for name in snapshot.joint_names]
        data = self._commands.encode(
            time, [item.position for item in wanted], [item.velocity for item in wanted]
        )
        file.write(JOINT_COMMANDS, JOINT_STATE, time, data, step)
        self._write_contacts(snapshot, time)
        self._write_changes(snapshot, setpoints, time)
        self._write_objects(snapshot, time)
        self._write_grippers(snapshot, time)
        for arm, sample in snapshot.arms.items():
            topic, wrenches = self._wrenches[arm]
            data = wrenches.encode(time, sample.wrench)
            file.write(topic, WRENCH, time, data, step)
        if snapshot.time >= self._next_frames:
            self._next_frames = snapshot.time + TF_PERIOD - _ROUNDING
            poses = [
                joint.pose(0.0 if index is None else snapshot.position[index])
                for joint, index in zip(self._joints, self._order, strict=True)
            ]
            file.write("/tf", TRANSFORMS, time, self._frames.encode(time, poses), step)

    def _write_changes(
        self, snapshot: Snapshot, setpoints: Mapping[str, JointSetpoint], time: int
    ) -> None:
        derived = Derived(
            targets={joint: item.target for joint, item in setpoints.items()},
            modes={arm: sample.mode for arm, sample in snapshot.arms.items()}
            or self._derived.modes,
            bodies=tuple(self._bodies),
        )
        change = encode_change(snapshot, self._before, derived, self._derived)
        self._before, self._derived = snapshot, derived
        if change is not None:
            self._file.write(STATE, TEXT, time, encode_text(change), snapshot.step)

    def _write_objects(self, snapshot: Snapshot, time: int) -> None:
        if snapshot.scene is not self._scene:
            self._scene = snapshot.scene
            self._attach_meshes(snapshot.scene)
            self._objects = object_transforms(
                self._root, [item.name for item in snapshot.scene]
            )
        if not self._scene:
            return
        poses = []
        for item in snapshot.objects:
            w, x, y, z = item.quat_wxyz
            poses.append((*item.position, x, y, z, w))
        data = self._objects.encode(time, poses)
        self._file.write(OBJECTS, TRANSFORMS, time, data, snapshot.step)

    def _write_contacts(self, snapshot: Snapshot, time: int) -> None:
        if not snapshot.arms and self._wrenches:
            return  # snapshot without forces
        if not snapshot.contacts and not self._had_contacts:
            return
        self._had_contacts = bool(snapshot.contacts)
        numbers, points = self._bodies, []
        for item in snapshot.contacts:
            first = numbers.setdefault(item.first, len(numbers))
            second = numbers.setdefault(item.second, len(numbers))
            points.append((*item.point, *item.force, *item.torque, first, second))
        data = self._contacts.encode(time, points)
        self._file.write(CONTACTS, POINTS, time, data, snapshot.step)

    def _write_grippers(self, snapshot: Snapshot, time: int) -> None:
        if not self._grippers:
            return
        openings, rates, forces = [], [], []
        for index, gripper in self._grippers:
            q = snapshot.position[index]
            lever = gripper.lever(q)
            openings.append(max(0.0, gripper.opening(q)))
            rates.append(-lever * snapshot.velocity[index])
            forces.append(snapshot.effort[index] / lever)
        data = self._gripper_states.encode(time, openings, rates, forces)
        self._file.write(GRIPPERS, JOINT_STATE, time, data, snapshot.step)

    def _attach_meshes(self, objects: Sequence[SceneObject]) -> None:
        """Attach the meshes of new objects."""
        new = {
            uri: path
            for uri, path in object_meshes(objects).items()
            if uri not in self._meshes
        }
        attach_meshes(self._file, new, _FIRST_OBJECT + len(self._meshes))
        self._meshes |= new


def object_transforms(root: str, names: Sequence[str]) -> Transforms:
    """Return the layout of ``/objects`` for the objects of a scene."""
    return Transforms([(root, name) for name in names])


def optical_frame(camera: str) -> str:
    """Return the frame of a camera's images (REP-103): z forward, x right, y down."""
    return f"{camera}_camera_color_optical_frame"


def contact_points(root: str) -> Points:
    """Return the layout of ``/contacts``.

    Each point contains a force [N], a torque [N·m] and the numbers of the two bodies.
    """
    parts = ("x", "y", "z", "fx", "fy", "fz", "tx", "ty", "tz")
    return Points(root, parts, ("first", "second"))


@final
class _JointFrame:
    """Frame of a joint's child link as a function of the joint's position."""

    def __init__(self, joint: Joint) -> None:
        self.name = joint.name
        self.frames = joint.parent, joint.child
        self._origin = to_transform(joint.origin)
        self._quat_wxyz = self._origin.quat_wxyz
        self._axis = joint.axis
        self.is_movable = joint.is_movable
        self._slides = joint.type is JointType.PRISMATIC

    def pose(self, q: float) -> tuple[float, ...]:
        """Return x, y, z [m], qx, qy, qz, qw in the parent link at ``q`` [rad | m]."""
        w, x, y, z = self._quat_wxyz
        ax, ay, az = self._axis
        if self._slides:
            position = self._origin.apply((q * ax, q * ay, q * az))
            return (*position, x, y, z, w)
        c, s = math.cos(0.5 * q), math.sin(0.5 * q)
        ax, ay, az = s * ax, s * ay, s * az
        return (
            *self._origin.position,
            w * ax + x * c + y * az - z * ay,
            w * ay + y * c + z * ax - x * az,
            w * az + z * c + x * ay - y * ax,
            w * c - x * ax - y * ay - z * az,
        )
