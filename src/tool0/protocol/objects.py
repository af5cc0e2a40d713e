"""The objects around the robot: their shapes as data, contacts, and requests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, final

from msgspec import Meta, Struct, structs

from tool0.description.scene import DEFAULT_FRICTION, LONGEST_MODEL, SceneObject
from tool0.description.scene_state import Contact
from tool0.description.shapes import (
    Box,
    Compound,
    Cylinder,
    Geometry,
    Mesh,
    Solid,
    Sphere,
    mesh,
)
from tool0.description.transform import Pose
from tool0.protocol.request import (
    RGBA,
    JointPositions,
    Length,
    Name,
    Place,
    Quaternion,
    Request,
    Vector3,
)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Collision:
    """Two things that would be in each other, on a path or at its end."""

    first: str
    """A link of the robot, or an object that it holds."""
    second: str
    """Another link, an object, or ``ground``."""
    depth: float
    """Largest depth on the path [m]."""
    begins: float
    """Place on the path where the collision begins: 0 at its start, 1 at its end."""
    depth_at_end: float
    """Depth at the end of the path [m]; 0 if they do not collide there."""


class BoxShape(Struct, frozen=True, kw_only=True, tag="box", tag_field="kind"):
    """A box, centred at its origin."""

    size: tuple[Length, Length, Length]
    """Edges [m]."""


class CylinderShape(
    Struct, frozen=True, kw_only=True, tag="cylinder", tag_field="kind"
):
    """A cylinder along z, centred at its origin."""

    radius: Length
    """Radius of the cylinder [m]."""
    length: Length
    """Length of the cylinder along z [m]."""


class SphereShape(Struct, frozen=True, kw_only=True, tag="sphere", tag_field="kind"):
    """A sphere around its origin."""

    radius: Length
    """Radius of the sphere [m]."""


class MeshShape(Struct, frozen=True, kw_only=True, tag="mesh", tag_field="kind"):
    """A mesh in a file on the simulation's machine."""

    file: str
    scale: Vector3 = (1.0, 1.0, 1.0)


SingleShape = BoxShape | CylinderShape | SphereShape | MeshShape


class ShapePart(Struct, frozen=True, kw_only=True):
    """One of the shapes of a body."""

    shape: SingleShape
    xyz: Place = (0.0, 0.0, 0.0)
    """Position of the shape's origin, in the body's frame [m]."""
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
    """Mass [kg]; None for a fixed object."""
    friction: float
    rgba: RGBA
    pose: Pose
    """Start position, in the robot's root."""


class AddObject(Request[None], frozen=True):
    """Add an object to the scene, at rest."""

    name: Name
    shape: Shape
    xyz: Place = (0.0, 0.0, 0.0)
    """Position of the object's origin, in the robot's root [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""
    mass: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Mass [kg]; if left out, the object is fixed."""
    friction: Annotated[float, Meta(ge=0.0, le=100.0)] = DEFAULT_FRICTION
    """Coulomb coefficient of sliding friction."""
    rgba: RGBA | None = None
    """Each within 0 … 1; a colour of its own, if left out."""
    allow_penetration: bool = False
    """Whether it may be inside a link."""

    def read_paths(self) -> tuple[str, ...]:
        return _mesh_files(self.shape)


class SpawnedModel(Struct, frozen=True, kw_only=True):
    """The object that a model became."""

    xyz: Vector3
    """Position of the object's origin, in the frame that the model was placed at
    [m]."""
    quat_wxyz: Quaternion
    """Orientation of the object, in that frame."""


class AddModel(Request[SpawnedModel], frozen=True):
    """Add the body of a URDF or SDF document to the scene, at rest.

    It has one link of simple shapes.  One that is ``<static>``, or fixed to a link
    ``world``, stands still.
    """

    name: Name
    model: Annotated[str, Meta(max_length=LONGEST_MODEL)]
    """The document."""
    xyz: Place = (0.0, 0.0, 0.0)
    """Position of the model's frame, in the robot's root [m]."""
    quat_wxyz: Quaternion = (1.0, 0.0, 0.0, 0.0)
    """Orientation of the model's frame, in the robot's root; any length but zero."""
    allow_penetration: bool = False
    """Whether it may be inside a link."""

    def read_paths(self) -> tuple[str, ...]:
        from tool0.description.rigid_model import mesh_uris  # only with documents

        return mesh_uris(self.model)


class RemoveObject(Request[None], frozen=True):
    """Remove an object from the scene."""

    name: Name


class PlaceObject(Request[None], frozen=True):
    """Place an object at once; a reset restores its start pose."""

    name: Name
    xyz: Place
    """Position of the object's origin, in the robot's root [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Fixed-axis roll, pitch, yaw [rad]."""
    quat_wxyz: Quaternion | None = None
    """Instead of roll, pitch and yaw; of any length but zero."""
    linear: Vector3 = (0.0, 0.0, 0.0)
    """Velocity of its origin, in the root's axes [m/s]."""
    angular: Vector3 = (0.0, 0.0, 0.0)
    """Angular velocity, in the root's axes [rad/s]."""
    allow_penetration: bool = False
    """Whether it may be inside a link."""


class ApplyWrench(Request[None], frozen=True):
    """Push a link or an object for a span of simulated time.

    Force and torque keep their direction in the robot's root.
    """

    name: Name
    """A link or an object that can move."""
    force: Vector3 = (0.0, 0.0, 0.0)
    """Force [N], in the axes of the robot's root."""
    torque: Vector3 = (0.0, 0.0, 0.0)
    """Torque [N·m], in the axes of the robot's root."""
    point: Place | None = None
    """Point at which the force acts at its start, in the robot's root [m]; the body's
    centre of mass, if left out."""
    start: Annotated[float, Meta(ge=0.0)] = 0.0
    """Simulated time at which it begins [s]; at once, if that is past."""
    duration: Annotated[float, Meta(ge=0.0)] | None = None
    """Simulated time for which it acts [s]; if left out, until it is cleared or the
    robot is reset."""


class PullLink(Request[None], frozen=True):
    """Pull a point of a link towards a place with a damped spring: one of a stream.

    It replaces another spring on the link.  Without an id, every one is executed at the
    next tick.
    """

    is_streamed = True

    name: Name
    """A link that can move."""
    point: Place
    """Point that the spring pulls, in the link's frame [m]."""
    target: Place
    """Place that the spring pulls it to, in the robot's root [m]."""
    stiffness: Annotated[float, Meta(gt=0.0, le=2000.0)] = 250.0
    """Stiffness of the spring [N/m]."""
    damping: Annotated[float, Meta(ge=0.0, le=100.0)] = 15.0
    """Damping of the spring [N·s/m]."""
    max_force: Annotated[float, Meta(gt=0.0, le=500.0)] = 80.0
    """Largest force of the spring [N]."""
    duration: Annotated[float, Meta(gt=0.0, le=10.0)] = 0.25
    """Simulated time after which it ends if no other follows [s]."""


class ClearWrenches(Request[None], frozen=True):
    """End the wrenches and springs on a link or an object, or all of them."""

    name: Name | None = None


class ReadContacts(Request[tuple[Contact, ...]], frozen=True):
    """The contact forces of the last physics step, one item for each pair that touches.

    The engine computes them only when asked; Gazebo reports none the first time.
    """


class FindCollisions(Request[tuple[Collision, ...]], frozen=True):
    """The collisions that the robot would have in a pose, and on the way to it.

    On the way, all joints move in proportion from where they are now, and what a
    gripper holds is carried along.  Pairs that are as deep in each other now are left
    out.  The pair whose collision begins first comes first.
    """

    positions: JointPositions
    """Joint → target [rad | m]; other joints stay."""


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


def with_meshes(shape: Shape, files: Mapping[str, Path]) -> Shape:
    """Return a shape whose meshes are read from elsewhere, by their former names."""
    match shape:
        case MeshShape(file=file) if file in files:
            return structs.replace(shape, file=str(files[file]))
        case CompoundShape(parts=parts):
            moved = (
                structs.replace(part, shape=with_meshes(part.shape, files))
                for part in parts
            )
            return CompoundShape(parts=tuple(moved))
    return shape


def _mesh_files(shape: Shape) -> tuple[str, ...]:
    """Return the files of a shape's meshes."""
    if isinstance(shape, CompoundShape):
        return tuple(file for part in shape.parts for file in _mesh_files(part.shape))
    return (shape.file,) if isinstance(shape, MeshShape) else ()


def _geometry_of(shape: SingleShape) -> Geometry:
    match shape:
        case BoxShape(size=size):
            return Box(size=size)
        case CylinderShape(radius=radius, length=length):
            return Cylinder(radius=radius, length=length)
        case SphereShape(radius=radius):
            return Sphere(radius=radius)
        case MeshShape(file=file, scale=scale):
            return mesh(file, scale)
