"""``tool0 scene``: the objects around the robot of a running bringup."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from tool0.cli.connection import DEFAULT, Bringup
from tool0.cli.text import columns
from tool0.description.scene import DEFAULT_FRICTION
from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere
from tool0.description.shapes import mesh as mesh_in
from tool0.description.transform import Pose, from_quaternion, to_pose, to_transform
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from tool0.description.scene import SceneObject
    from tool0.hardware.engine import ObjectState

Three = tuple[float, float, float]
Name = Annotated[str, tyro.conf.Positional]
_ZERO: Three = (0.0, 0.0, 0.0)


def show(
    *,
    as_json: Annotated[bool, tyro.conf.arg(name="json")] = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """List the objects: what they are and where.

    Positions are in the robot's root [m], roll pitch yaw in degrees.

    Args:
        as_json: Print one JSON object, in metres and with quaternions.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        snapshot = robot.snapshot
    found = list(zip(snapshot.scene, snapshot.objects, strict=True))
    if as_json:
        rows = [_plain(item, state) for item, state in found]
        print(json.dumps({"objects": rows}))
    else:
        head = ("name", "shape", "mass", "x y z [m]", "roll pitch yaw [deg]")
        rows_of_text = [_row(item, state) for item, state in found]
        print(columns([head, *rows_of_text]), end="")


def add(
    name: Name,
    *,
    box: Three | None = None,
    cylinder: tuple[float, float] | None = None,
    sphere: float | None = None,
    mesh: Path | None = None,
    scale: float | None = None,
    xyz: Three = _ZERO,
    rpy: Three = _ZERO,
    mass: float | None = None,
    friction: float = DEFAULT_FRICTION,
    rgba: tuple[float, float, float, float] | None = None,
    bringup: Bringup = DEFAULT,
) -> None:
    """Add an object, at rest.

    Args:
        name: What it is to be called.
        box: Its edges along x, y, z [m].
        cylinder: Its radius and its length along z [m].
        sphere: Its radius [m].
        mesh: Its STL or OBJ file.
        scale: What the mesh's lengths are multiplied by to be metres; 1 if left out.
        xyz: Where its origin is to be, in the robot's root [m].
        rpy: How it is to be turned there, roll pitch yaw [rad].
        mass: Its mass [kg]; without one it stands still.
        friction: Its coefficient of friction.
        rgba: Its colour, each within 0 … 1.
        bringup: Which bringup.
    """
    shape = _shape(box, cylinder, sphere, mesh, scale)
    with bringup.connect() as robot:
        robot.scene.add(
            name, shape, xyz=xyz, rpy=rpy, mass=mass, friction=friction, rgba=rgba
        )


def remove(
    names: Annotated[tuple[str, ...], tyro.conf.Positional],
    bringup: Bringup = DEFAULT,
) -> None:
    """Remove objects.

    Args:
        names: The objects.
        bringup: Which bringup.
    """
    if not names:
        raise ConfigError("name at least one object; see `tool0 scene list`")
    with bringup.connect() as robot:
        for name in names:
            robot.scene.remove(name)


def place(
    name: Name, *, xyz: Three, rpy: Three = _ZERO, bringup: Bringup = DEFAULT
) -> None:
    """Put an object somewhere at once, at rest.

    Args:
        name: The object.
        xyz: Where its origin is to be, in the robot's root [m].
        rpy: How it is to be turned there, roll pitch yaw [rad].
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        robot.scene.place(name, xyz, to_transform(Pose(xyz=xyz, rpy=rpy)).quat_wxyz)


scene = {"list": show, "add": add, "remove": remove, "place": place}


def _shape(
    box: Three | None,
    cylinder: tuple[float, float] | None,
    sphere: float | None,
    mesh: Path | None,
    scale: float | None,
) -> Geometry:
    if scale is not None and mesh is None:
        raise ConfigError("--scale goes with --mesh")
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
        "still" if item.mass is None else f"{item.mass:g} kg",
        " ".join(_signed(part, 4) for part in pose.xyz),
        " ".join(_signed(math.degrees(part), 1) for part in pose.rpy),
    )


def _signed(value: float, digits: int) -> str:
    """Return a rounded number with its sign; what is rounded to 0 has a plus."""
    return f"{round(value, digits) + 0.0:+.{digits}f}"


def _described(shape: Geometry) -> str:
    match shape:
        case Box(size=(x, y, z)):
            return f"box {x:g} x {y:g} x {z:g}"
        case Cylinder(radius=radius, length=length):
            return f"cylinder {radius:g} x {length:g}"
        case Sphere(radius=radius):
            return f"sphere {radius:g}"
        case Mesh(path=path):
            return f"mesh {path.name}"


def _plain(item: SceneObject, state: ObjectState) -> dict[str, object]:
    from msgspec import to_builtins

    from tool0.requests.objects import shape_of

    return {
        "name": item.name,
        "shape": to_builtins(shape_of(item.geometry)),
        "mass": item.mass,
        "friction": item.friction,
        **{key: value for key, value in asdict(state).items() if key != "name"},
    }
