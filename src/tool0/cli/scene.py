"""``tool0 scene``: the objects around the robot of a running bringup."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tool0.cli.connection import DEFAULT, Bringup
from tool0.cli.parameters import AsJson, Option
from tool0.cli.text import columns, print_json
from tool0.description.scene import DEFAULT_FRICTION
from tool0.description.shapes import (
    Box,
    Compound,
    Cylinder,
    Geometry,
    Mesh,
    Solid,
    Sphere,
)
from tool0.description.shapes import mesh as mesh_in
from tool0.description.transform import (
    Pose,
    Vector3,
    from_quaternion,
    to_pose,
    to_transform,
)
from tool0.description.units import Metres, Radians
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from tool0.cli.outputs import SceneOutput
    from tool0.description.scene import SceneObject
    from tool0.description.scene_state import ObjectState

Name = Annotated[str, Option(is_positional=True, metavar="OBJECT")]
Place = Annotated[tuple[Metres, Metres, Metres], Option(metavar="X Y Z")]
Angles = Annotated[tuple[Radians, Radians, Radians], Option(metavar="ROLL PITCH YAW")]
Cylindrical = Annotated[tuple[Metres, Metres], Option(metavar="RADIUS LENGTH")]
Colour = Annotated[tuple[float, float, float, float], Option(metavar="R G B A")]
_ZERO = (0.0, 0.0, 0.0)


def show(
    *,
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """List the objects with their shapes, masses and poses.

    Positions are in the robot's root frame [m]; roll, pitch and yaw are in degrees.

    Args:
        as_json: Print one JSON object, with lengths in meters and orientations as
            quaternions.
    """
    with bringup.connect() as robot:
        snapshot = robot.snapshot
    found = list(zip(snapshot.scene, snapshot.objects, strict=True))
    if as_json:
        listed: SceneOutput = {"objects": [_plain(*each) for each in found]}
        print_json(listed)
    else:
        head = ("name", "shape", "mass", "x y z [m]", "roll pitch yaw [deg]")
        rows_of_text = [_row(item, state) for item, state in found]
        print(columns([head, *rows_of_text]), end="")


def add(
    name: Name,
    *,
    box: Place | None = None,
    cylinder: Cylindrical | None = None,
    sphere: Metres | None = None,
    mesh: Path | None = None,
    scale: float | None = None,
    xyz: Place = _ZERO,
    rpy: Angles = _ZERO,
    mass: float | None = None,
    friction: float = DEFAULT_FRICTION,
    rgba: Colour | None = None,
    allow_penetration: bool = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """Add an object: a box, a cylinder, a sphere or a mesh.

    Args:
        name: Name of the new object.
        box: Edge lengths of a box along x, y and z [m].
        cylinder: Radius of a cylinder, and its length along z [m].
        sphere: Radius of a sphere [m].
        mesh: STL or OBJ file of a mesh.
        scale: Factor that converts the mesh file's unit to meters, such as 0.001 for
            millimeters; the default is 1.
        xyz: Position of the object's origin in the robot's root frame [m].
        rpy: Orientation of the object in the robot's root frame [rad].
        mass: Mass [kg]; an object without a mass cannot move.
        friction: Coefficient of friction.
        rgba: Color: red, green, blue and opacity, each between 0 and 1.
        allow_penetration: Add the object even if it penetrates a link.
    """
    shape = _shape(box, cylinder, sphere, mesh, scale)
    with bringup.connect() as robot:
        robot.scene.add(
            name,
            shape,
            xyz=xyz,
            rpy=rpy,
            mass=mass,
            friction=friction,
            rgba=rgba,
            allow_penetration=allow_penetration,
        )


def remove(
    names: Annotated[tuple[str, ...], Option(is_positional=True, metavar="OBJECT ...")],
    bringup: Bringup = DEFAULT,
) -> None:
    """Remove objects.

    Args:
        names: Names of the objects.
    """
    with bringup.connect() as robot:
        for name in names:
            robot.scene.remove(name)


def place(
    name: Name,
    *,
    xyz: Place,
    rpy: Angles = _ZERO,
    allow_penetration: bool = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """Place an object at a pose, at rest.

    Args:
        name: Name of the object.
        xyz: Position of the object's origin in the robot's root frame [m].
        rpy: Orientation of the object in the robot's root frame [rad].
        allow_penetration: Place the object even if it penetrates a link.
    """
    with bringup.connect() as robot:
        robot.scene.place(
            name,
            xyz,
            to_transform(Pose(xyz=xyz, rpy=rpy)).quat_wxyz,
            allow_penetration=allow_penetration,
        )


scene = {"list": show, "add": add, "remove": remove, "place": place}


def _shape(
    box: Vector3 | None,
    cylinder: tuple[float, float] | None,
    sphere: float | None,
    mesh: Path | None,
    scale: float | None,
) -> Geometry:
    if scale is not None and mesh is None:
        raise ConfigError("--scale needs --mesh")
    shapes: list[Geometry] = []
    if box is not None:
        shapes.append(Box(size=box))
    if cylinder is not None:
        shapes.append(Cylinder(radius=cylinder[0], length=cylinder[1]))
    if sphere is not None:
        shapes.append(Sphere(radius=sphere))
    if mesh is not None:
        shapes.append(mesh_in(mesh, 1.0 if scale is None else scale))
    if len(shapes) != 1:
        raise ConfigError(
            f"give one shape, --box, --cylinder, --sphere or --mesh; got {len(shapes)}"
        )
    return shapes[0]


def _row(item: SceneObject, state: ObjectState) -> tuple[str, ...]:
    pose = to_pose(from_quaternion(state.position, state.quat_wxyz))
    return (
        item.name,
        _described(item.geometry),
        "fixed" if item.mass is None else f"{item.mass:g} kg",
        " ".join(_signed(part, 4) for part in pose.xyz),
        " ".join(_signed(math.degrees(part), 1) for part in pose.rpy),
    )


def _signed(value: float, digits: int) -> str:
    """Return a rounded number with its sign; the sign of 0 is a plus."""
    return f"{round(value, digits) + 0.0:+.{digits}f}"


def _described(shape: Solid) -> str:
    match shape:
        case Box(size=(x, y, z)):
            return f"box {x:g} x {y:g} x {z:g}"
        case Cylinder(radius=radius, length=length):
            return f"cylinder {radius:g} x {length:g}"
        case Sphere(radius=radius):
            return f"sphere {radius:g}"
        case Mesh(path=path):
            return f"mesh {path.name}"
        case Compound(parts=parts):
            return f"{len(parts)} shapes"


def _plain(item: SceneObject, state: ObjectState) -> dict[str, object]:
    from msgspec import to_builtins

    from tool0.protocol.objects import shape_of

    return {
        "name": item.name,
        "shape": to_builtins(shape_of(item.geometry)),
        "mass": item.mass,
        "friction": item.friction,
        **{key: value for key, value in asdict(state).items() if key != "name"},
    }
