"""Models in Gazebo's world, and contacts with names from the URDF and scene.

libsdformat lumps each fixed link into the link to which it is fixed, and names each
shape after its original link.
"""

from __future__ import annotations

import contextlib
import logging
import math
import re
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import final

import numpy as np

from tool0.description.bodies import Matrix, MovingBody, fixed_to_world
from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import Contact, ObjectState
from tool0.description.transform import Pose, Vector3, pose_matrix
from tool0.engines.gazebo.connection import (
    ANSWER_TIMEOUT,
    SPAWN_TIMEOUT,
    BridgeConnection,
    RequestKind,
    pack_floats,
    pack_pose,
    pack_text,
)
from tool0.engines.gazebo.robot_urdf import MimicConstraint
from tool0.engines.gazebo.sdf import check_model, object_sdf
from tool0.engines.gazebo.server import GazeboServer
from tool0.errors import (
    DescriptionError,
    EngineError,
    EngineUnavailableError,
    ModelError,
    SourceLocation,
    did_you_mean,
)
from tool0.hardware.engine import (
    Wrench,
    check_attachable,
    check_new_name,
    check_placement,
    find_object,
    immovable,
)

logger = logging.getLogger(__name__)

_WORLD_REPLACED = "Falling back on"
_INCOMPLETE_MODEL = "Loading model from factory message failed"
_MESH_MISSING = "Unable to load mesh"
"""Errors in gzserver's log after which gzserver continues."""


@final
class GazeboServerWorld:
    """A ``World`` in one gzserver; the bridge provides access to this world."""

    def __init__(
        self,
        connection: BridgeConnection,
        server: GazeboServer,
        model: RobotModel,
        bodies: tuple[MovingBody, ...],
        *,
        urdf: str,
        gears: Sequence[MimicConstraint],
        root: Matrix,
        scene: Scene,
        world_file: Path | None,
        finish_step: Callable[[], None],
    ) -> None:
        """Spawn the robot and the scene, and bind the bridge to the robot.

        ``urdf`` is the robot's URDF for libsdformat.  The bridge simulates the
        ``gears``.  ``root`` is the pose of the robot's root in the world, shape (4, 4),
        which must be a pure translation.  ``world_file`` is None for the empty world of
        tool0.  ``finish_step`` is called before each request, in order to receive the
        answer to a pending step.

        Raises:
            DescriptionError: If Gazebo cannot read the world.
            EngineError: If Gazebo rejects the robot or an object.
        """
        self._connection = connection
        self._server = server
        self._model = model
        self._root = root
        self._names = LinkNames(model, bodies, own_world=world_file is None)
        self._finish_step = finish_step
        self._objects: dict[str, SceneObject] = {}  # in the same order as in the bridge
        self._states: tuple[ObjectState, ...] = ()
        self.ground = None if world_file else -float(root[2, 3])
        file = server.folder / "robot.urdf"
        file.write_text(urdf)
        self._spawn(model.name, file, root, world_file=world_file)
        for item in scene.objects:
            self.spawn(item)
        armatures = model.transmission_by_joint
        joints = [joint.name for joint in model.movable_joints]
        answer = self._request(
            RequestKind.BIND,
            pack_text(model.name),
            struct.pack("=I", len(joints)),
            *(
                pack_text(name)
                + pack_floats([armatures[name].armature if name in armatures else 0.0])
                for name in joints
            ),
            struct.pack("=I", len(gears)),
            *(
                struct.pack("=IId", gear.joint, gear.other, gear.multiplier)
                for gear in gears
            ),
        )
        x, y, z = struct.unpack("=3d", answer)
        self.gravity: Vector3 = (x, y, z)

    def start_poses(self) -> bytes:
        """Return the poses of the objects after a reset, in the bridge's format."""
        return b"".join(
            pack_pose(self._root @ pose_matrix(item.pose))
            for item in self._objects.values()
        )

    def object_states(self) -> tuple[ObjectState, ...]:
        """Return the current state of each object.

        If gzserver has exited, the last known states are returned, and the next step
        raises an error.
        """
        if not self._objects:
            return ()
        with contextlib.suppress(EngineUnavailableError):
            rows = struct.iter_unpack("=13d", self._request(RequestKind.OBJECTS))
            self._states = tuple(
                self._in_root(name, row)
                for name, row in zip(self._objects, rows, strict=True)
            )
        return self._states

    def spawn(self, item: SceneObject) -> None:
        check_new_name(self._objects, item.name)
        file = self._server.folder / f"{item.name}.sdf"
        try:
            file.write_text(object_sdf(item))
        except ModelError as error:
            raise ModelError(f"object '{item.name}': {error}") from None
        self._spawn(
            item.name, file, self._root @ pose_matrix(item.pose), is_object=True
        )
        self._objects[item.name] = item

    def spawn_file(self, name: str, file: Path, pose: Pose) -> None:
        """Add the model of a URDF or SDF file at ``pose`` in the robot's root.

        Raises:
            DescriptionError: If the file is not XML with a model.
            EngineError: If Gazebo rejects the model, or can build only a part of it.
        """
        check_model(file)
        self._spawn(name, file.resolve(), self._root @ pose_matrix(pose))

    def delete(self, name: str) -> None:
        """Remove a model other than the robot, or raise EngineError."""
        if name == self._model.name:
            raise EngineError(f"'{name}' is the robot, which cannot be removed")
        try:
            self._request(RequestKind.DELETE, pack_text(name), timeout=SPAWN_TIMEOUT)
        except EngineUnavailableError:
            raise
        except EngineError as error:
            hint = did_you_mean(name, set(self._objects))
            raise EngineError(f"{error}{hint}") from None
        self._objects.pop(name, None)

    def place(self, state: ObjectState) -> None:
        check_placement(self._objects, state)
        x, y, z = state.position
        norm = math.hypot(*state.quat_wxyz)
        self._request(
            RequestKind.PLACE,
            pack_text(state.name),
            pack_floats((x, y, z + float(self._root[2, 3]))),
            pack_floats([part / norm for part in state.quat_wxyz]),
            pack_floats((*state.linear, *state.angular)),
        )

    def contacts(self) -> tuple[Contact, ...]:
        """Return the contacts of the last step, one contact per pair.

        Each item of a pair is a link or an object.  Gazebo starts to record contacts at
        the first call, and therefore the first call returns no contacts.
        """
        packed, n, left = b"", 0, 1
        while left:  # the size of an answer is limited
            answer = self._request(RequestKind.CONTACTS, struct.pack("=I", n))
            n_here, left = struct.unpack_from("=2I", answer)
            packed += answer[8:]
            n += n_here
        return unpack_contacts(packed, self._names, self._root)

    def is_touched(self, links: frozenset[str]) -> bool:
        return any(not links.isdisjoint((c.first, c.second)) for c in self.contacts())

    def center_of_mass(self, name: str) -> Vector3:
        answer = self._request(RequestKind.CENTER, self._packed_body(name))
        x, y, z = struct.unpack("=3d", answer)
        return x, y, z - float(self._root[2, 3])

    def hold_wrenches(self, wrenches: Mapping[str, Wrench]) -> None:
        self._request(
            RequestKind.WRENCHES,
            struct.pack("=I", len(wrenches)),
            *(
                self._packed_body(name) + pack_floats((*force, *torque))
                for name, (force, torque) in wrenches.items()
            ),
        )

    def _packed_body(self, name: str) -> bytes:
        """Return Gazebo's model and link names for a link or object, in packed form."""
        if name in self._names.body_of_link:
            body = self._names.body_of_link[name]
            if not body:
                raise immovable(name)
            return pack_text(self._model.name) + pack_text(body)
        if find_object(self._objects, name).mass is None:
            raise immovable(name)
        return pack_text(name) + pack_text("link")

    def attach(self, name: str, link: str) -> None:
        self._model.link(link)
        check_attachable(self._objects, name)
        body = self._names.body_of_link[link]
        self._request(
            RequestKind.ATTACH, pack_text(name), pack_text(body), pack_text(link)
        )

    def detach(self, name: str) -> None:
        self._request(RequestKind.DETACH, pack_text(name))

    def _request(
        self, kind: RequestKind, *parts: bytes, timeout: float = ANSWER_TIMEOUT
    ) -> memoryview:
        self._finish_step()
        return self._connection.request(kind, *parts, timeout=timeout)

    def _spawn(
        self,
        name: str,
        file: Path,
        pose: Matrix,
        *,
        is_object: bool = False,
        world_file: Path | None = None,
    ) -> None:
        """Add the model in a file, and check gzserver's log for errors.

        Objects are listed, placed and reset in the order in which they were spawned.
        """
        prefix = f"object '{name}': " if is_object else ""
        try:
            self._request(
                RequestKind.SPAWN,
                pack_text(name),
                pack_text(str(file)),
                pack_pose(pose),
                struct.pack("=I", is_object),
                timeout=SPAWN_TIMEOUT,
            )
        except EngineUnavailableError:
            raise
        except EngineError as error:
            raise EngineError(f"{prefix}{error}{self._new_errors()}") from None
        errors = self._new_errors()
        # This error is logged when the first model, the robot, is added.
        if _WORLD_REPLACED in errors:
            where = SourceLocation(world_file)
            raise DescriptionError(f"Gazebo cannot read this world:{errors}", where)
        if _INCOMPLETE_MODEL in errors or (is_object and _MESH_MISSING in errors):
            self._request(RequestKind.DELETE, pack_text(name), timeout=SPAWN_TIMEOUT)
            raise EngineError(f"{prefix}Gazebo cannot build '{name}':{errors}")
        if errors:
            logger.warning("Gazebo reports errors:%s", errors)

    def _new_errors(self) -> str:
        return "".join(f"\n  {line}" for line in self._server.new_errors())

    def _in_root(self, name: str, row: tuple[float, ...]) -> ObjectState:
        x, y, z, qw, qx, qy, qz, vx, vy, vz, wx, wy, wz = row
        return ObjectState(
            name,
            (x, y, z - float(self._root[2, 3])),
            (qw, qx, qy, qz),
            (vx, vy, vz),
            (wx, wy, wz),
        )


_NUMBERS = struct.Struct("=10d")
_REVERSED = np.array([1.0] * 4 + [-1.0] * 6)
"""Factors for the ten numbers of a contact if the two names of the contact are
swapped."""
_GROUND = ("ground_plane", "ground")
"""Name of the ground's model in the empty world of tool0, and name of the ground in
contacts."""
_LUMP = "_fixed_joint_lump__"
"""Text between the name of the merged link and the name of the original link of a
shape.  This text is missing if the original name starts with the name of the merged
link."""
_NUMBERED = re.compile(r"_collision(_\d+)?$")


@final
class LinkNames:
    """The names of one robot's links in Gazebo and in the URDF."""

    def __init__(
        self, model: RobotModel, bodies: tuple[MovingBody, ...], *, own_world: bool
    ) -> None:
        """Collect the names of the links, and of the ground if ``own_world`` is set."""
        self._robot = model.name
        self._ground = dict([_GROUND]) if own_world else {}
        self.body_of_link = {link: "" for link, _ in fixed_to_world(model)}
        """Map from a URDF link to the Gazebo link into which it was lumped; "" denotes
        the world."""
        for body in bodies:
            for link, _ in body.links:
                self.body_of_link[link] = body.joint.child

    def owner(self, model: str, shape: str) -> str:
        """Return the link or object of a shape in Gazebo."""
        if model == self._robot:
            link = _NUMBERED.sub("", shape.rpartition(_LUMP)[2])
            return link if link in self.body_of_link else shape
        return self._ground.get(model, model)


def unpack_contacts(
    packed: bytes, names: LinkNames, root: Matrix
) -> tuple[Contact, ...]:
    """Return one contact per pair, in the axes of the robot's root.

    ``packed`` contains all pairs of shapes, in the bridge's format.  ``root`` is the
    pose of the robot's root in the world, shape (4, 4), which must be a pure
    translation.
    """
    sums: dict[tuple[str, str], Matrix] = {}
    for (first, second), numbers in _unpack(packed, names):
        if (second, first) in sums:
            sums[second, first] += numbers * _REVERSED
        elif (first, second) in sums:
            sums[first, second] += numbers
        else:
            sums[first, second] = numbers
    found = []
    for (first, second), total in sums.items():
        moment, force, torque = total[1:4], total[4:7], total[7:10]
        point = moment / total[0]
        vectors = (point - root[:3, 3], force, torque - np.cross(point, force))
        found.append(Contact(first, second, *(tuple(v.tolist()) for v in vectors)))
    return tuple(found)


def _unpack(
    packed: bytes, names: LinkNames
) -> Iterator[tuple[tuple[str, str], Matrix]]:
    """Yield each pair of names with the numbers in ``ContactSum`` (see contacts.h)."""
    rest = packed
    while rest:
        *words, rest = rest.split(b"\0", 4)
        first, one, second, other = (word.decode() for word in words)
        numbers = np.array(_NUMBERS.unpack_from(rest))
        rest = rest[_NUMBERS.size :]
        yield (names.owner(first, one), names.owner(second, other)), numbers
