"""Handle for the objects around a robot: ``robot.scene``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import final, overload

from tool0.description.scene import DEFAULT_FRICTION, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import RGBA, Solid, mesh
from tool0.description.transform import Transform, from_quaternion
from tool0.errors import ControlError, RequestError, did_you_mean
from tool0.protocol.channel import Channel
from tool0.protocol.objects import AddObject, PlaceObject, RemoveObject, shape_of
from tool0.protocol.request import checked_value
from tool0.protocol.state import Snapshot


@final
class SceneHandle:
    """The objects around a robot, by name, in the order in which they were added."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        """The current objects with their start poses."""
        return self._channel.snapshot.scene

    @property
    def states(self) -> Mapping[str, ObjectState]:
        """Pose and velocity of each object, in the robot's root frame."""
        return {state.name: state for state in self._channel.snapshot.objects}

    def __iter__(self) -> Iterator[str]:
        return (item.name for item in self.objects)

    def __len__(self) -> int:
        return len(self.objects)

    def __contains__(self, name: object) -> bool:
        return any(item.name == name for item in self.objects)

    def __getitem__(self, name: str) -> SceneObject:
        """Return the object called ``name``; raise ControlError for an unknown name."""
        objects = {item.name: item for item in self.objects}
        if name not in objects:
            raise _unknown(name, list(objects))
        return objects[name]

    def pose(self, name: str) -> Transform:
        """Return the measured pose of an object in the robot's root frame.

        Raises:
            ControlError: If there is no object with this name.
        """
        checked_value("pose", "name", name, str)
        return object_pose(self._channel.snapshot, name)

    @overload
    def add(
        self, item: SceneObject, /, *, allow_penetration: bool = ...
    ) -> SceneObject: ...

    @overload
    def add(
        self,
        item: str,
        shape: Solid | Path | str,
        /,
        *,
        xyz: Sequence[float] = ...,
        rpy: Sequence[float] = ...,
        mass: float | None = ...,
        friction: float = ...,
        rgba: RGBA | None = ...,
        allow_penetration: bool = ...,
    ) -> SceneObject: ...

    def add(
        self,
        item: SceneObject | str,
        shape: Solid | Path | str | None = None,
        /,
        *,
        xyz: Sequence[float] = (0.0, 0.0, 0.0),
        rpy: Sequence[float] = (0.0, 0.0, 0.0),
        mass: float | None = None,
        friction: float = DEFAULT_FRICTION,
        rgba: RGBA | None = None,
        allow_penetration: bool = False,
    ) -> SceneObject:
        """Add an object to the scene, at rest, and return it.

        Motions continue.  The control loop waits while the object is added: a few
        milliseconds in MuJoCo (longer for a large mesh), and 0.2 s in Gazebo.  In real
        time, the control loop then catches up with the wall clock.

        Args:
            item: Name of the object, or a complete ``SceneObject``.  With a
                ``SceneObject``, leave out the arguments from ``shape`` to ``rgba``.
            shape: ``Box``, ``Cylinder``, ``Sphere``, ``Mesh``, a ``Compound`` of such
                shapes, or a mesh file in meters (``tool0.scene.mesh`` scales other
                units).
            xyz: Position of the object's origin, in the robot's root frame [m].
            rpy: Orientation of the object: fixed-axis roll, pitch and yaw [rad].
            mass: Mass [kg]; an object without a mass is fixed.
            friction: Coulomb coefficient of sliding friction.
            rgba: Red, green, blue and opacity, each 0 … 1; by default, the color is
                selected automatically.
            allow_penetration: Whether the object may penetrate a link by more than 2
                mm.

        Raises:
            PenetrationError: If the object would penetrate a link.
            ConfigError: If the object is physically impossible, or has the name of a
                link.
            ControlError: If a value has the wrong type or is out of bounds.
            DescriptionError: If the mesh file does not exist.
            ModelError: If the engine does not support the object.
            EngineError: If an object with this name already exists, or if the engine
                refuses the object.
        """
        if isinstance(item, SceneObject):
            name, shape = item.name, item.geometry
            xyz, rpy = item.pose.xyz, item.pose.rpy
            mass, friction, rgba = item.mass, item.friction, item.rgba
        else:
            name = item
        if shape is None:
            raise RequestError("add", f"object '{name}' needs a shape, as Box(size=…)")
        geometry = mesh(shape) if isinstance(shape, (str, Path)) else shape
        request = AddObject(
            name=name,
            shape=shape_of(geometry),
            xyz=xyz,  # type: ignore[arg-type]  # any sequence: the channel checks it
            rpy=rpy,  # type: ignore[arg-type]
            mass=mass,
            friction=friction,
            rgba=rgba,
            allow_penetration=allow_penetration,
        )
        self._channel.call(request)
        return self[name]

    def remove(self, name: str) -> None:
        """Remove an object from the scene.

        Raises:
            EngineError: If there is no object with this name.
        """
        self._channel.call(RemoveObject(name=name))

    def place(
        self,
        name: str,
        position: Sequence[float],
        quat_wxyz: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        *,
        linear: Sequence[float] = (0.0, 0.0, 0.0),
        angular: Sequence[float] = (0.0, 0.0, 0.0),
        allow_penetration: bool = False,
    ) -> None:
        """Move an object to a pose instantly; ``reset`` restores its start pose.

        Args:
            name: Name of the object.
            position: Position of the object's origin, in the robot's root frame [m].
            quat_wxyz: Orientation of the object, as a quaternion with any nonzero norm.
            linear: Velocity of the object's origin, in the axes of the root frame
                [m/s].
            angular: Angular velocity of the object, in the axes of the root frame
                [rad/s].
            allow_penetration: Whether the object may penetrate a link by more than 2
                mm.

        Raises:
            PenetrationError: If the object would penetrate a link.
            ControlError: If a value has the wrong number of elements, or is not finite.
            EngineError: If the object does not exist, or if a velocity is given for an
                object without a mass.
        """
        self._channel.call(
            PlaceObject(
                name=name,
                xyz=position,  # type: ignore[arg-type]  # any sequence: see add
                quat_wxyz=quat_wxyz,  # type: ignore[arg-type]
                linear=linear,  # type: ignore[arg-type]
                angular=angular,  # type: ignore[arg-type]
                allow_penetration=allow_penetration,
            )
        )


def object_pose(snapshot: Snapshot, name: str) -> Transform:
    """Return an object's pose in the root frame; a wrong name raises ControlError."""
    for state in snapshot.objects:
        if state.name == name:
            return from_quaternion(state.position, state.quat_wxyz)
    raise _unknown(name, [state.name for state in snapshot.objects])


def _unknown(name: str, names: list[str]) -> ControlError:
    return ControlError(
        f"there is no object '{name}' in the scene{did_you_mean(name, names)}"
    )
