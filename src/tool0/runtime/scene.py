"""The one way to what is around the robot: ``robot.scene``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import final, overload

from tool0.description.scene import (
    DEFAULT_FRICTION,
    PALETTE,
    RGBA,
    STILL_RGBA,
    SceneObject,
)
from tool0.description.shapes import Geometry, mesh
from tool0.description.transform import Pose, Transform, from_quaternion
from tool0.errors import ControlError, did_you_mean
from tool0.hardware.engine import ObjectState
from tool0.runtime import commands as ask
from tool0.runtime.bus import Snapshot
from tool0.runtime.loop import Loop
from tool0.runtime.scene_objects import object_state, three_numbers


@final
class SceneHandle:
    """The objects around a robot, by name, in the order in which they came."""

    def __init__(self, loop: Loop, snapshot: Callable[[], Snapshot]) -> None:
        self._loop = loop
        self._snapshot = snapshot

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        """What is there now, each with the pose at which it began."""
        return self._snapshot().scene

    @property
    def states(self) -> Mapping[str, ObjectState]:
        """Where each object is and how it moves, in the robot's root."""
        return {state.name: state for state in self._snapshot().objects}

    def __iter__(self) -> Iterator[str]:
        return (item.name for item in self.objects)

    def __len__(self) -> int:
        return len(self.objects)

    def __contains__(self, name: object) -> bool:
        return any(item.name == name for item in self.objects)

    def __getitem__(self, name: str) -> SceneObject:
        """Return the object called ``name``, or raise ControlError."""
        objects = {item.name: item for item in self.objects}
        if name not in objects:
            raise _unknown(name, list(objects))
        return objects[name]

    def pose(self, name: str) -> Transform:
        """Return the frame of an object in the robot's root, or raise ControlError."""
        return object_pose(self._snapshot(), name)

    @overload
    def add(self, item: SceneObject, /) -> SceneObject: ...

    @overload
    def add(
        self,
        item: str,
        shape: Geometry | Path | str,
        /,
        *,
        xyz: Sequence[float] = ...,
        rpy: Sequence[float] = ...,
        mass: float | None = ...,
        friction: float = ...,
        rgba: RGBA | None = ...,
    ) -> SceneObject: ...

    def add(
        self,
        item: SceneObject | str,
        shape: Geometry | Path | str | None = None,
        /,
        *,
        xyz: Sequence[float] = (0.0, 0.0, 0.0),
        rpy: Sequence[float] = (0.0, 0.0, 0.0),
        mass: float | None = None,
        friction: float = DEFAULT_FRICTION,
        rgba: RGBA | None = None,
    ) -> SceneObject:
        """Put a further object into the scene, at rest, and return it.

        What moves goes on moving.  The loop stands still for it: some milliseconds in
        MuJoCo, more for a large mesh, 0.2 s in Gazebo.  In real time it catches up.

        Args:
            item: Its name, or a whole object; the rest is then left out.
            shape: ``Box``, ``Cylinder``, ``Sphere``, ``Mesh``, or a mesh's file in
                metres (``tool0.scene.mesh`` scales others).
            xyz: Where its origin is to be, in the robot's root [m].
            rpy: How it is to be turned there, fixed-axis roll, pitch, yaw [rad].
            mass: [kg]; None stands still, whatever pushes it.
            friction: Coulomb's coefficient for sliding.
            rgba: Each within 0 … 1; a colour of its own if left out.

        Raises:
            ConfigError: If there can be no such object, or it has the name of a link.
            ControlError: If xyz or rpy has another number of parts than three.
            DescriptionError: If there is no such mesh.
            ModelError: If the engine cannot have such an object.
            EngineError: If an object has this name, or the engine refuses.
        """
        if isinstance(item, str):
            if shape is None:
                raise TypeError(f"object '{item}' needs a shape, as Box(size=…)")
            item = SceneObject(
                name=item,
                geometry=mesh(shape) if isinstance(shape, (str, Path)) else shape,
                pose=Pose(
                    xyz=three_numbers(item, "position", xyz),
                    rpy=three_numbers(item, "rpy", rpy),
                ),
                mass=mass,
                friction=friction,
                rgba=rgba or self._usual_rgba(mass),
            )
        self._loop.call(ask.SpawnObject(item))
        return item

    def remove(self, name: str) -> None:
        """Take an object out of the scene, or raise EngineError if there is none."""
        self._loop.call(ask.DeleteObject(name))

    def place(
        self,
        name: str,
        position: Sequence[float],
        quat_wxyz: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        *,
        linear: Sequence[float] = (0.0, 0.0, 0.0),
        angular: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Put an object somewhere at once, at rest or moving; ``reset`` puts it back.

        Args:
            name: The object.
            position: Where its origin is to be, in the robot's root [m].
            quat_wxyz: How it is to be turned there, of any length.
            linear: Velocity of its origin, in the root's axes [m/s].
            angular: How fast it is to turn, in the root's axes [rad/s].

        Raises:
            ControlError: If a value has another number of parts, or is not finite.
            EngineError: If there is no such object, or it has no mass and is to move.
        """
        self._loop.call(
            ask.PlaceObject(object_state(name, position, quat_wxyz, linear, angular))
        )

    def _usual_rgba(self, mass: float | None) -> RGBA:
        """Return the colour of a further object that names none."""
        if mass is None:
            return STILL_RGBA
        movable = sum(item.mass is not None for item in self.objects)
        return PALETTE[movable % len(PALETTE)]


def object_pose(snapshot: Snapshot, name: str) -> Transform:
    """Return where an object was then, in the robot's root, or raise ControlError."""
    for state in snapshot.objects:
        if state.name == name:
            return from_quaternion(state.position, state.quat_wxyz)
    raise _unknown(name, [state.name for state in snapshot.objects])


def _unknown(name: str, names: list[str]) -> ControlError:
    return ControlError(
        f"there is no object '{name}' in the scene{did_you_mean(name, names)}"
    )
