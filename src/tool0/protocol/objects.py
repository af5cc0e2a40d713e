"""Objects around the robot: shapes in the sent form, collisions, and requests."""

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
    """Two bodies that would overlap on a path or at its end."""

    first: str
    """First body: a link of the robot, or an object that it holds."""
    second: str
    """Second body: a link, an object, or ``ground``."""
    depth: float
    """Maximum penetration depth on the path [m]."""
    begins: float
    """Position on the path where the collision begins, from 0 (start) to 1 (end)."""
    depth_at_end: float
    """Penetration depth at the end of the path [m]; 0 if the bodies do not overlap
    there."""


class BoxShape(Struct, frozen=True, kw_only=True, tag="box", tag_field="kind"):
    """A box, centered at its origin."""

    size: tuple[Length, Length, Length]
    """Edge lengths along x, y and z [m]."""


class CylinderShape(
    Struct, frozen=True, kw_only=True, tag="cylinder", tag_field="kind"
):
    """A cylinder along z, centered at its origin."""

    radius: Length
    """Radius of the cylinder [m]."""
    length: Length
    """Length of the cylinder along z [m]."""


class SphereShape(Struct, frozen=True, kw_only=True, tag="sphere", tag_field="kind"):
    """A sphere, centered at its origin."""

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
    """Position of the shape's origin in the frame of the body [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Orientation: fixed-axis roll, pitch and yaw [rad]."""


class CompoundShape(
    Struct, frozen=True, kw_only=True, tag="compound", tag_field="kind"
):
    """Several shapes of equal density that form one rigid body."""

    parts: tuple[ShapePart, ...]


Shape = SingleShape | CompoundShape


class ObjectInfo(Struct, frozen=True, kw_only=True):
    """An object of the scene."""

    name: str
    shape: Shape
    mass: float | None
    """Mass of the object [kg]; None for a fixed object."""
    friction: float
    rgba: RGBA
    pose: Pose
    """Start pose of the object, in the robot's root frame."""


class AddObject(Request[None], frozen=True):
    """Add an object to the scene, at rest."""

    name: Name
    shape: Shape
    xyz: Place = (0.0, 0.0, 0.0)
    """Position of the object's origin in the robot's root frame [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Orientation: fixed-axis roll, pitch and yaw [rad]."""
    mass: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Mass of the object [kg]; without a mass, the object is fixed."""
    friction: Annotated[float, Meta(ge=0.0, le=100.0)] = DEFAULT_FRICTION
    """Coulomb coefficient of sliding friction of the object."""
    rgba: RGBA | None = None
    """Red, green, blue and opacity, each from 0 to 1; by default, a color is selected
    automatically."""
    allow_penetration: bool = False
    """Whether the object may overlap with a link."""

    def read_paths(self) -> tuple[str, ...]:
        return _mesh_files(self.shape)


class SpawnedModel(Struct, frozen=True, kw_only=True):
    """An object that was created from a model."""

    xyz: Vector3
    """Position of the object's origin in the frame at which the model was placed
    [m]."""
    quat_wxyz: Quaternion
    """Orientation of the object in the frame at which the model was placed."""


class AddModel(Request[SpawnedModel], frozen=True):
    """Add the body of a URDF or SDF document to the scene, at rest.

    The model must have one link that consists of simple shapes.  If the model is
    ``<static>``, or is fixed to a link ``world``, the object is fixed.
    """

    name: Name
    model: Annotated[str, Meta(max_length=LONGEST_MODEL)]
    """Text of the URDF or SDF document."""
    xyz: Place = (0.0, 0.0, 0.0)
    """Position of the model's frame in the robot's root frame [m]."""
    quat_wxyz: Quaternion = (1.0, 0.0, 0.0, 0.0)
    """Orientation of the model's frame in the robot's root frame; the quaternion is
    normalized on receipt."""
    allow_penetration: bool = False
    """Whether the object may overlap with a link."""

    def read_paths(self) -> tuple[str, ...]:
        from tool0.description.rigid_model import mesh_uris  # needed only for documents

        return mesh_uris(self.model)


class RemoveObject(Request[None], frozen=True):
    """Remove an object from the scene."""

    name: Name


class PlaceObject(Request[None], frozen=True):
    """Place an object immediately; a reset restores its start pose."""

    name: Name
    xyz: Place
    """Position of the object's origin in the robot's root frame [m]."""
    rpy: Vector3 = (0.0, 0.0, 0.0)
    """Orientation: fixed-axis roll, pitch and yaw [rad]."""
    quat_wxyz: Quaternion | None = None
    """Orientation, instead of roll, pitch and yaw; the quaternion can have any nonzero
    norm."""
    linear: Vector3 = (0.0, 0.0, 0.0)
    """Velocity of the object's origin, in the axes of the root frame [m/s]."""
    angular: Vector3 = (0.0, 0.0, 0.0)
    """Angular velocity of the object, in the axes of the root frame [rad/s]."""
    allow_penetration: bool = False
    """Whether the object may overlap with a link."""


class ApplyWrench(Request[None], frozen=True):
    """Apply a wrench to a link or an object for some simulated time.

    The force and the torque keep their directions in the robot's root frame.
    """

    name: Name
    """Name of a link or an object that can move."""
    force: Vector3 = (0.0, 0.0, 0.0)
    """Force [N], in the axes of the robot's root frame."""
    torque: Vector3 = (0.0, 0.0, 0.0)
    """Torque [N·m], in the axes of the robot's root frame."""
    point: Place | None = None
    """Initial point of action of the force, in the robot's root frame [m]; the default
    is the body's center of mass.  The point follows the translation of the body, but
    not its rotation."""
    start: Annotated[float, Meta(ge=0.0)] = 0.0
    """Simulated time at which the wrench begins [s]; if this time has passed, the
    wrench begins immediately."""
    duration: Annotated[float, Meta(ge=0.0)] | None = None
    """Simulated time for which the wrench acts [s].  Without a duration, the wrench
    acts until it is cleared or the robot is reset."""


class PullLink(Request[None], frozen=True):
    """Use a damped spring to pull a point of a link toward a target.

    The spring replaces an earlier spring on the link.  In a stream of requests without
    an id, each request is executed at the next tick.
    """

    is_streamed = True

    name: Name
    """Name of a link that can move."""
    point: Place
    """Point that the spring pulls, in the frame of the link [m]."""
    target: Place
    """Position to which the spring pulls the point, in the robot's root frame [m]."""
    stiffness: Annotated[float, Meta(gt=0.0, le=2000.0)] = 250.0
    """Stiffness of the spring [N/m]."""
    damping: Annotated[float, Meta(ge=0.0, le=100.0)] = 15.0
    """Damping of the spring [N·s/m]."""
    max_force: Annotated[float, Meta(gt=0.0, le=500.0)] = 80.0
    """Maximum force of the spring [N]."""
    duration: Annotated[float, Meta(gt=0.0, le=10.0)] = 0.25
    """Simulated time after which the spring ends if no further request follows [s]."""


class ClearWrenches(Request[None], frozen=True):
    """End all wrenches and springs on one body, or on all bodies if none is given."""

    name: Name | None = None


class ReadContacts(Request[tuple[Contact, ...]], frozen=True):
    """Read the contact forces of the last physics step, one for each pair in contact.

    The engine computes contact forces only on request.  With Gazebo, the first response
    is empty.
    """


class FindCollisions(Request[tuple[Collision, ...]], frozen=True):
    """Find the collisions of the robot at a pose and on the path to it.

    On the path, all joints move synchronously from their current positions, and objects
    in grippers move with the grippers.  A pair that already overlaps at least as deeply
    at present is left out.  The pairs are sorted by where on the path their collisions
    begin.
    """

    positions: JointPositions
    """Joint → target position [rad | m]; the other joints do not move."""


def shape_of(solid: Solid) -> Shape:
    """Return the sent form of a shape."""
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
    """Return the sent form of an object."""
    return ObjectInfo(
        name=item.name,
        shape=shape_of(item.geometry),
        mass=item.mass,
        friction=item.friction,
        rgba=item.rgba,
        pose=item.pose,
    )


def object_of(info: ObjectInfo) -> SceneObject:
    """Return the object that a received ``ObjectInfo`` describes."""
    return SceneObject(
        name=info.name,
        geometry=solid_of(info.shape),
        pose=info.pose,
        mass=info.mass,
        friction=info.friction,
        rgba=info.rgba,
    )


def solid_of(shape: Shape) -> Solid:
    """Return a shape from its sent form; a missing mesh raises DescriptionError."""
    if not isinstance(shape, CompoundShape):
        return _geometry_of(shape)
    return Compound(
        parts=tuple(
            (_geometry_of(part.shape), Pose(xyz=part.xyz, rpy=part.rpy))
            for part in shape.parts
        )
    )


def with_meshes(shape: Shape, files: Mapping[str, Path]) -> Shape:
    """Return a shape with replaced mesh files; ``files`` maps old names to files."""
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
    """Return the mesh files of a shape."""
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
