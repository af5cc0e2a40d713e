"""What pages ask for of objects, carried out by the façade."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tool0.description.shapes import Box, Cylinder, Geometry, Sphere
from tool0.description.transform import Pose, to_transform
from tool0.errors import ConfigError
from tool0.interfaces.panel.protocol import (
    AddedShape,
    AddObject,
    PlaceObject,
    RemoveObject,
)

if TYPE_CHECKING:
    from tool0.runtime.scene import SceneHandle

MOST_OBJECTS = 500
"""So many may be there for a page to add one: each makes every later one slower."""


def change_objects(
    scene: SceneHandle, message: AddObject | RemoveObject | PlaceObject
) -> None:
    """Do what a page asked, or raise Tool0Error."""
    match message:
        case AddObject():
            _add(scene, message)
        case RemoveObject(name=name):
            scene.remove(name)
        case PlaceObject(name=name, position=position, rpy=rpy):
            pose = to_transform(Pose(xyz=position, rpy=rpy))
            scene.place(name, pose.position, pose.quat_wxyz)


def _add(scene: SceneHandle, message: AddObject) -> None:
    if len(scene) >= MOST_OBJECTS:
        raise ConfigError(f"{MOST_OBJECTS} objects are there already; remove some")
    scene.add(
        message.name,
        _geometry(message.shape, message.name),
        xyz=message.position,
        rpy=message.rpy,
        mass=message.mass,
        friction=message.friction,
        rgba=message.rgba,
    )


def _geometry(shape: AddedShape, name: str) -> Geometry:
    match shape:
        case AddedShape(kind="box", size=(_, _, _) as size, radius=None, length=None):
            return Box(size=size)
        case AddedShape(
            kind="cylinder", size=None, radius=float(radius), length=float(length)
        ):
            return Cylinder(radius=radius, length=length)
        case AddedShape(kind="sphere", size=None, radius=float(radius), length=None):
            return Sphere(radius=radius)
    raise ConfigError(
        f"object '{name}': a box has a size, a cylinder radius and length, a sphere a "
        f"radius; got {shape}"
    )
