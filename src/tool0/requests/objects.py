"""Requests about the objects around the robot."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

from msgspec import Meta, Struct

from tool0.description.rigid_model import MAX_LENGTH, read_rigid_model
from tool0.description.scene import DEFAULT_FRICTION, PALETTE, STILL_RGBA, SceneObject
from tool0.description.shapes import (
    Box,
    Compound,
    Cylinder,
    Geometry,
    Mesh,
    Solid,
    Sphere,
    mesh,
    parts_of,
)
from tool0.description.transform import Pose, from_quaternion, to_transform
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
from tool0.runtime.applied_wrenches import AppliedWrench
from tool0.runtime.simulation import Simulation

MOST_SHAPES = 500
"""Largest number of shapes in a scene that requests may add to: adding gets slower with
each."""


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


SingleShape = BoxShape | CylinderShape | SphereShape | MeshShape


class ShapePart(Struct, frozen=True, kw_only=True):
    """One of the shapes of a body."""

    shape: SingleShape
    xyz: Place = (0.0, 0.0, 0.0)
    """Of its origin, in the body's frame [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""


class CompoundShape(
    Struct, frozen=True, kw_only=True, tag="compound", tag_field="kind"
):
    """Several shapes that are one rigid body, of the same density."""

    parts: tuple[ShapePart, ...]


Shape = SingleShape | CompoundShape


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
    """Coulomb coefficient of sliding friction."""
    rgba: RGBA | None = None
    """Each within 0 … 1; a colour of its own, if left out."""


class SpawnedModel(Struct, frozen=True, kw_only=True):
    """The object that a model became."""

    xyz: Vector3
    """Of the object's origin, in the frame that the model was placed at [m]."""
    quat_wxyz: Quaternion
    """Of the object, in that frame."""


class AddModel(Request[SpawnedModel], frozen=True):
    """Add the body of a URDF or SDF document to the scene, at rest.

    It has one link of simple shapes.  One that is ``<static>``, or fixed to a link
    ``world``, stands still.
    """

    name: Name
    model: Annotated[str, Meta(max_length=MAX_LENGTH)]
    """The document."""
    xyz: Place = (0.0, 0.0, 0.0)
    """Of the model's frame, in the robot's root [m]."""
    quat_wxyz: Quaternion = (1.0, 0.0, 0.0, 0.0)
    """Of the model's frame; of any length but zero."""


class RemoveObject(Request[None], frozen=True):
    """Remove an object from the scene."""

    name: Name


class PlaceObject(Request[None], frozen=True):
    """Place an object at once; a reset restores its start pose."""

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


class ApplyWrench(Request[None], frozen=True):
    """Push a link or an object for a span of simulated time.

    Force and torque keep their direction in the robot's root.
    """

    name: Name
    """A link or an object that can move."""
    force: Vector3 = (0.0, 0.0, 0.0)
    """[N]"""
    torque: Vector3 = (0.0, 0.0, 0.0)
    """[N·m]"""
    point: Place | None = None
    """Where the force acts at its start, in the robot's root [m]; the body's centre of
    mass, if left out."""
    start: Annotated[float, Meta(ge=0.0)] = 0.0
    """Simulated time at which it begins [s]; at once, if that is past."""
    duration: Annotated[float, Meta(ge=0.0)] | None = None
    """[s]; until it is cleared or the robot is reset, if left out."""


class ClearWrenches(Request[None], frozen=True):
    """End the wrenches that were applied to a link or an object, or to all of them."""

    name: Name | None = None


class ReadContacts(Request[tuple[Contact, ...]], frozen=True):
    """The contact forces of the last physics step, one item for each pair that touches.

    The engine computes them only when asked; Gazebo reports none the first time.
    """


def shape_of(solid: Solid) -> Shape:
    """Return a shape as it is sent."""
    if not isinstance(solid, Compound):
        return _single_shape(solid)
    return CompoundShape(
        parts=tuple(
            ShapePart(shape=_single_shape(geometry), xyz=pose.xyz, rpy=pose.rpy)
            for geometry, pose in solid.parts
        )
    )


def _single_shape(geometry: Geometry) -> SingleShape:
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
        geometry=solid_of(info.shape),
        pose=info.pose,
        mass=info.mass,
        friction=info.friction,
        rgba=info.rgba,
    )


def solid_of(shape: Shape) -> Solid:
    """Return the shape that was sent; DescriptionError without the file of a mesh."""
    if not isinstance(shape, CompoundShape):
        return _geometry_of(shape)
    return Compound(
        parts=tuple(
            (_geometry_of(part.shape), Pose(xyz=part.xyz, rpy=part.rpy))
            for part in shape.parts
        )
    )


def _geometry_of(shape: SingleShape) -> Geometry:
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
    rgba = request.rgba
    if rgba is None:
        movable = sum(item.mass is not None for item in scene)
        rgba = STILL_RGBA if request.mass is None else PALETTE[movable % len(PALETTE)]
    item = SceneObject(
        name=request.name,
        geometry=solid_of(request.shape),
        pose=Pose(xyz=request.xyz, rpy=request.rpy),
        mass=request.mass,
        friction=request.friction,
        rgba=rgba,
    )
    _spawn(simulation, item)


@handles(AddModel)
def _add_model(simulation: Simulation, request: AddModel) -> SpawnedModel:
    if not math.hypot(*request.quat_wxyz) > 0.0:
        raise ConfigError("'quat_wxyz' must not be zero")
    model = read_rigid_model(request.model)
    T_root_frame = from_quaternion(request.xyz, request.quat_wxyz)
    item = model.scene_object(request.name, T_root_frame @ model.placement)
    _spawn(simulation, item)
    T_frame_shape = model.placement @ model.T_model_shape
    return SpawnedModel(xyz=T_frame_shape.position, quat_wxyz=T_frame_shape.quat_wxyz)


def _spawn(simulation: Simulation, item: SceneObject) -> None:
    """Add an object, unless there would be too many shapes."""
    solids = [*(known.geometry for known in simulation.snapshot.scene), item.geometry]
    count = sum(len(parts_of(solid)) for solid in solids)
    if count > MOST_SHAPES:
        raise ConfigError(
            f"the objects would have {count} shapes; {MOST_SHAPES} is the most; "
            "remove some"
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


@handles(ApplyWrench, in_tick=True)
def _apply_wrench(simulation: Simulation, request: ApplyWrench) -> None:
    wrench = AppliedWrench(
        name=request.name,
        force=request.force,
        torque=request.torque,
        point=request.point,
        start=request.start,
        duration=math.inf if request.duration is None else request.duration,
    )
    simulation.core.scene.wrenches.add(wrench)


handles(ClearWrenches, in_tick=True)(
    lambda sim, request: sim.core.scene.wrenches.clear(request.name)
)
handles(ReadContacts, in_tick=True, publishes=False)(
    lambda sim, _: sim.core.engine.world.contacts()
)
