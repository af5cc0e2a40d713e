"""What is in Gazebo's world: put there, told to the bridge, taken away."""

from __future__ import annotations

import logging
import math
import struct
from pathlib import Path
from typing import final

from tool0.description.model import RobotModel, Transmission
from tool0.description.scene import Scene, SceneObject
from tool0.description.transform import Pose, Vector3, pose_matrix
from tool0.engines.gazebo.connection import (
    Connection,
    Kind,
    numbers,
    pose_bytes,
    text,
)
from tool0.engines.gazebo.couplings import Coupling
from tool0.engines.gazebo.objects import object_sdf
from tool0.engines.gazebo.server import Server
from tool0.engines.gazebo.touches import Names, contacts_from
from tool0.errors import (
    DescriptionError,
    EngineError,
    EngineUnavailableError,
    ModelError,
    SourceLocation,
    did_you_mean,
)
from tool0.hardware.bodies import Matrix
from tool0.hardware.engine import Contact, ObjectState

logger = logging.getLogger(__name__)

_OTHER_WORLD = "Falling back on"
_HALF_BUILT = "Loading model from factory message failed"
_NO_MESH = "Unable to load mesh"
"""What gzserver says, and otherwise goes on as if nothing were."""


@final
class Models:
    """The models in the world of one gzserver."""

    def __init__(
        self,
        connection: Connection,
        server: Server,
        world: Path | None,
        root: Matrix,
        names: Names,
    ) -> None:
        """Ask over ``connection``.

        Args:
            connection: To the bridge.
            server: The one that it is in.
            world: The file of the world, for messages.
            root: The robot's root in the world, shape (4, 4): moved, not turned.
            names: Of the robot's links.
        """
        self._connection = connection
        self._server = server
        self._world = world
        self._root = root
        self._names = names
        self._robot = ""
        self._objects: dict[str, SceneObject] = {}  # as the bridge lists them

    def populate(
        self,
        model: RobotModel,
        urdf: str,
        gears: tuple[Coupling, ...],
        scene: Scene,
    ) -> Vector3:
        """Spawn the robot and the scene, and bind the bridge to the robot.

        Returns:
            The gravity of the world [m/s²].

        Args:
            model: The robot.
            urdf: What libsdformat makes it of.
            gears: The couplings that are for the bridge to hold.
            scene: The objects around it.

        Raises:
            EngineError: If Gazebo refuses one of them.
        """
        file = self._server.folder / "robot.urdf"
        file.write_text(urdf)
        self._spawn(model.name, file, self._root)
        self._robot = model.name
        for item in scene.objects:
            self.spawn(item)
        return self._bind(model, gears)

    def start_poses(self) -> bytes:
        """Return where a reset puts the objects, as the bridge reads it."""
        return b"".join(
            pose_bytes(self._root @ pose_matrix(item.pose))
            for item in self._objects.values()
        )

    def object_states(self) -> tuple[ObjectState, ...]:
        """Return how the objects are, in the order of their coming."""
        if not self._objects:
            return ()
        rows = struct.iter_unpack("=13d", self._connection.ask(Kind.OBJECTS))
        return tuple(
            self._seen_from_root(name, row)
            for name, row in zip(self._objects, rows, strict=True)
        )

    def spawn(self, item: SceneObject) -> None:
        """Put an object into the world.

        Raises:
            ModelError: If it is a mesh that cannot be read, or is to move and encloses
                nothing.
            EngineError: If Gazebo does not take it.
        """
        if item.name in self._objects:
            raise EngineError(f"there is an object '{item.name}' already")
        file = self._server.folder / f"{item.name}.sdf"
        file.write_text(object_sdf(item))
        pose = self._root @ pose_matrix(item.pose)
        try:
            self._spawn(item.name, file, pose, is_object=True)
        except EngineUnavailableError:
            raise
        except EngineError as error:
            raise EngineError(f"object '{item.name}': {error}") from error
        self._objects[item.name] = item

    def spawn_file(self, name: str, file: Path, pose: Pose) -> None:
        """Put the model of a person's file into the world, at ``pose`` in the root.

        Raises:
            EngineError: If Gazebo does not take it, or only half of it.
        """
        self._spawn(name, file, self._root @ pose_matrix(pose))

    def delete(self, name: str) -> None:
        """Take an object, or another model, out of the world.

        Raises:
            EngineError: If there is none, or it is the robot.
        """
        if name == self._robot:
            raise EngineError(f"'{name}' is the robot, which stays")
        try:
            self._connection.delete(name)
        except EngineUnavailableError:
            raise
        except EngineError as error:
            hint = did_you_mean(name, set(self._objects))
            raise EngineError(f"{error}{hint}") from None
        self._objects.pop(name, None)

    def place(self, state: ObjectState) -> None:
        """Put an object somewhere, moving so.

        Raises:
            EngineError: If there is none, or it stands still and is to move.
        """
        item = self._object(state.name)
        velocity = (*state.linear, *state.angular)
        if item.mass is None and any(velocity):
            raise EngineError(f"object '{state.name}' has no mass: it cannot move")
        x, y, z = state.position
        norm = math.hypot(*state.quat_wxyz)
        self._connection.ask(
            Kind.PLACE,
            text(state.name),
            numbers((x, y, z + float(self._root[2, 3]))),
            numbers([part / norm for part in state.quat_wxyz]),
            numbers(velocity),
        )

    def contacts(self) -> tuple[Contact, ...]:
        """Return what touched in the last step; nothing when asked first."""
        told, n, left = b"", 0, 1
        while left:  # as many as go into an answer
            answer = self._connection.ask(Kind.CONTACTS, struct.pack("=I", n))
            some, left = struct.unpack_from("=2I", answer)
            told += answer[8:]
            n += some
        return contacts_from(told, self._names, self._root)

    def attach(self, name: str, link: str) -> None:
        """Fix an object to a link as it is now.

        Raises:
            ModelError: If there is no such link.
            EngineError: If there is no such object, it stands still, or it is
                attached already.
        """
        links = self._names.body_of_link
        if link not in links:
            hint = did_you_mean(link, set(links))
            raise ModelError(f"there is no link '{link}'{hint}")
        if self._object(name).mass is None:
            raise EngineError(f"object '{name}' has no mass: it cannot move")
        self._connection.ask(Kind.ATTACH, text(name), text(links[link]), text(link))

    def detach(self, name: str) -> None:
        """Let an object go, if it is attached."""
        self._connection.ask(Kind.DETACH, text(name))

    def _object(self, name: str) -> SceneObject:
        item = self._objects.get(name)
        if item is None:
            hint = did_you_mean(name, set(self._objects))
            raise EngineError(f"there is no object '{name}'{hint}")
        return item

    def _spawn(
        self, name: str, file: Path, pose: Matrix, *, is_object: bool = False
    ) -> None:
        try:
            self._connection.spawn(name, file, pose, is_object=is_object)
        except EngineUnavailableError:
            raise
        except EngineError as error:
            raise EngineError(f"{error}{self._complaints()}") from None
        complaints = self._complaints()
        if _OTHER_WORLD in complaints:  # the first model's world, that is
            where = SourceLocation(self._world)
            raise DescriptionError(f"Gazebo cannot read this world:{complaints}", where)
        if _HALF_BUILT in complaints or (is_object and _NO_MESH in complaints):
            self._connection.delete(name)
            raise EngineError(f"Gazebo cannot build '{name}':{complaints}")
        if complaints:
            logger.warning("Gazebo complains:%s", complaints)

    def _bind(self, model: RobotModel, gears: tuple[Coupling, ...]) -> Vector3:
        transmissions = model.transmission_by_joint
        names = [joint.name for joint in model.movable_joints]
        answer = self._connection.ask(
            Kind.BIND,
            text(model.name),
            struct.pack("=I", len(names)),
            *(
                text(name) + numbers([_armature(transmissions.get(name))])
                for name in names
            ),
            struct.pack("=I", len(gears)),
            *(
                struct.pack("=IId", gear.joint, gear.other, gear.multiplier)
                for gear in gears
            ),
        )
        x, y, z = struct.unpack("=3d", answer)
        return x, y, z

    def _seen_from_root(self, name: str, row: tuple[float, ...]) -> ObjectState:
        x, y, z, qw, qx, qy, qz, vx, vy, vz, wx, wy, wz = row
        return ObjectState(
            name,
            (x, y, z - float(self._root[2, 3])),
            (qw, qx, qy, qz),
            (vx, vy, vz),
            (wx, wy, wz),
        )

    def _complaints(self) -> str:
        return "".join(f"\n  {line}" for line in self._server.complaints())


def _armature(transmission: Transmission | None) -> float:
    return transmission.armature if transmission else 0.0
