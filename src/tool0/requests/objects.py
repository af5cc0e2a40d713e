"""Requests about the objects around the robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from msgspec import Meta, Struct

from tool0.description.scene import DEFAULT_FRICTION, PALETTE, STILL_RGBA, SceneObject
from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere, mesh
from tool0.description.transform import Pose, to_transform
from tool0.errors import ConfigError
from tool0.hardware.engine import Contact, ObjectState
from tool0.requests.table import (
    RGBA,
    Length,
    Name,
    Place,
    Quaternion,
    Request,
    Vector3,
    handles,
)
from tool0.runtime.simulation import Simulation

MOST_OBJECTS = 500
"""Objects of a scene to which requests may add: each one slows down the next."""


class BoxShape(Struct, frozen=True, kw_only=True, tag="box", tag_field="kind"):
    """A box, centred at its origin."""

    size: tuple[Length, Length, Length]
    """Edges [m]."""


class CylinderShape(
    Struct, frozen=True, kw_only=True, tag="cylinder", tag_field="kind"
):
    """A cylinder along z, centred at its origin."""

    radius: Length
    """[m]"""
    length: Length
    """[m]"""


class SphereShape(Struct, frozen=True, kw_only=True, tag="sphere", tag_field="kind"):
    """A sphere around its origin."""

    radius: Length
    """[m]"""


class MeshShape(Struct, frozen=True, kw_only=True, tag="mesh", tag_field="kind"):
    """A mesh in a file on the simulation's machine."""

    file: str
    scale: Vector3 = (1.0, 1.0, 1.0)


Shape = BoxShape | CylinderShape | SphereShape | MeshShape


class ObjectInfo(Struct, frozen=True, kw_only=True):
    """An object of the scene."""

    name: str
    shape: Shape
    mass: float | None
    """[kg]; None is fixed."""
    friction: float
    rgba: RGBA
    pose: Pose
    """Where it started, in the robot's root."""


class AddObject(Request[None], frozen=True):
    """Add an object to the scene, at rest."""

    name: Name
    shape: Shape
    xyz: Place = (0.0, 0.0, 0.0)
    """Of its origin, in the robot's root [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""
    mass: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """[kg]; without one it is fixed."""
    friction: Annotated[float, Meta(ge=0.0, le=100.0)] = DEFAULT_FRICTION
    """Coulomb's coefficient for sliding."""
    rgba: RGBA | None = None
    """Each within 0 … 1; a colour of its own, if left out."""


class RemoveObject(Request[None], frozen=True):
    """Remove an object from the scene."""

    name: Name


class PlaceObject(Request[None], frozen=True):
    """Put an object somewhere at once; a reset puts it back."""

    name: Name
    xyz: Place
    """Of its origin, in the robot's root [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""
    quat_wxyz: Quaternion | None = None
    """Instead of roll, pitch and yaw; of any length but zero."""
    linear: Vector3 = (0.0, 0.0, 0.0)
    """Velocity of its origin, in the root's axes [m/s]."""
    angular: Vector3 = (0.0, 0.0, 0.0)
    """Angular velocity, in the root's axes [rad/s]."""


class ReadContacts(Request[tuple[Contact, ...]], frozen=True):
    """The contact forces of the last physics step, one item for each pair that touches.

    The engine computes them only when asked; Gazebo reports none the first time.
    """


def shape_of(geometry: Geometry) -> Shape:
    """Return a shape as it is sent."""
    match geometry:
        case Box(size=size):
            return BoxShape(size=size)
        case Cylinder(radius=radius, length=length):
            return CylinderShape(radius=radius, length=length)
        case Sphere(radius=radius):
            return SphereShape(radius=radius)
        case Mesh(path=path, scale=scale):
            return MeshShape(file=str(path), scale=scale)


def info_of(item: SceneObject) -> ObjectInfo:
    """Return an object as it is sent."""
    return ObjectInfo(
        name=item.name,
        shape=shape_of(item.geometry),
        mass=item.mass,
        friction=item.friction,
        rgba=item.rgba,
        pose=item.pose,
    )


def object_of(info: ObjectInfo) -> SceneObject:
    """Return the object that was sent."""
    return SceneObject(
        name=info.name,
        geometry=geometry_of(info.shape),
        pose=info.pose,
        mass=info.mass,
        friction=info.friction,
        rgba=info.rgba,
    )


def geometry_of(shape: Shape) -> Geometry:
    """Return the geometry that was sent; DescriptionError without the mesh's file."""
    match shape:
        case BoxShape(size=size):
            return Box(size=size)
        case CylinderShape(radius=radius, length=length):
            return Cylinder(radius=radius, length=length)
        case SphereShape(radius=radius):
            return Sphere(radius=radius)
        case MeshShape(file=file, scale=scale):
            return mesh(Path(file), scale)


@handles(AddObject)
def _add(simulation: Simulation, request: AddObject) -> None:
    scene = simulation.snapshot.scene
    if len(scene) >= MOST_OBJECTS:
        raise ConfigError(f"there are {MOST_OBJECTS} objects already; remove some")
    rgba = request.rgba
    if rgba is None:
        movable = sum(item.mass is not None for item in scene)
        rgba = STILL_RGBA if request.mass is None else PALETTE[movable % len(PALETTE)]
    item = SceneObject(
        name=request.name,
        geometry=geometry_of(request.shape),
        pose=Pose(xyz=request.xyz, rpy=request.rpy),
        mass=request.mass,
        friction=request.friction,
        rgba=rgba,
    )
    simulation.loop.call(lambda: simulation.core.scene.spawn(item))


handles(RemoveObject, in_tick=True)(
    lambda sim, request: sim.core.scene.delete(request.name)
)


@handles(PlaceObject, in_tick=True)
def _place(simulation: Simulation, request: PlaceObject) -> None:
    pose = Pose(xyz=request.xyz, rpy=request.rpy)
    quat_wxyz = request.quat_wxyz or to_transform(pose).quat_wxyz
    state = ObjectState(
        request.name, request.xyz, quat_wxyz, request.linear, request.angular
    )
    simulation.core.scene.place(state)


handles(ReadContacts, in_tick=True, publishes=False)(
    lambda sim, _: sim.core.engine.world.contacts()
)
