"""A scene's YAML file, read into values.

The keys are those of ``SceneObject``, but that the geometry goes by its kind::

    objects:
      - {name: table, box: {size: [0.6, 0.8, 0.04]}, pose: {xyz: [0.6, 0, 0]}}
      - {name: can, cylinder: {radius: 0.03, length: 0.1}, mass: 0.2, friction: 0.6}
      - {name: part, mesh: {file: part.stl, scale: [0.001, 0.001, 0.001]}, mass: 0.1}
      - {name: tray, bin: {size: [0.3, 0.2, 0.1], wall: 0.004}}

A bin is an open box that stands still; it becomes the objects ``tray.floor``,
``tray.front``, ….  ``cameras:`` is in ``camera_file``.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tool0.description.bins import DEFAULT_WALL, bin_walls
from tool0.description.camera_file import read_cameras
from tool0.description.mesh_files import find_mesh
from tool0.description.model import Box, Cylinder, Geometry, Mesh, Pose, Sphere
from tool0.description.scene import (
    DEFAULT_FRICTION,
    PALETTE,
    RGBA,
    STILL_RGBA,
    Scene,
    SceneObject,
    check_geometry,
)
from tool0.description.shipped_scenes import scene_path
from tool0.description.yaml_tree import Entry, read_files
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, DescriptionError, SourceLocation


def load_scene(path: Path | str) -> Scene:
    """Return the objects in a YAML file, or in a scene that comes along.

    Args:
        path: The file, or the name of one of ``shipped_scenes``.

    Raises:
        ConfigError: If anything in it is wrong, with file and line.
    """
    tree = read_files([scene_path(path)])
    for finding in tree.findings:  # no later key may hide an earlier one
        raise ConfigError(
            f"'{finding.key}' stands twice; {finding.remedy}", finding.location
        )
    root = Namespace(tree.root)
    root.only("objects", "cameras")
    colors = itertools.cycle(PALETTE)
    objects: dict[str, SceneObject] = {}
    locations: dict[str, SourceLocation] = {}
    for entry in root.items("objects"):
        for item in _objects(entry, colors):
            if item.name in objects:
                raise ConfigError(
                    f"two objects are called '{item.name}', the other at "
                    f"{locations[item.name]}; rename one",
                    entry.location,
                )
            objects[item.name], locations[item.name] = item, entry.location
    return Scene(
        tuple(objects.values()), locations, read_cameras(root.items("cameras"))
    )


def _objects(entry: Entry, colors: Iterator[RGBA]) -> tuple[SceneObject, ...]:
    """Return what an entry stands for: one object, or the walls of a bin."""
    values = Namespace.of(entry)
    values.only("name", "pose", "mass", "friction", "rgba", *_KINDS)
    mass = values.number("mass") if values.find("mass") is not None else None
    if values.find("rgba") is not None:
        red, green, blue, alpha = values.numbers("rgba", 4)
        rgba = (red, green, blue, alpha)
    else:
        rgba = STILL_RGBA if mass is None else next(colors)
    name = values.text("name")
    kind, shape = _shape(values, name)
    friction = values.number("friction", DEFAULT_FRICTION)
    if kind == _BIN:
        shape.only("size", "wall")
        if mass is not None:
            raise ConfigError(
                f"bin '{name}' stands still; leave out its mass", entry.location
            )
        with _located(shape.entry):
            return bin_walls(
                name,
                size=shape.vector("size"),
                wall=shape.number("wall", DEFAULT_WALL),
                pose=_pose(values),
                friction=friction,
                rgba=rgba,
            )
    geometry = _SHAPES[kind](shape)
    with _located(shape.entry):
        check_geometry(geometry, f"of object '{name}'")
    with _located(entry):
        item = SceneObject(
            name=name,
            geometry=geometry,
            pose=_pose(values),
            mass=mass,
            friction=friction,
            rgba=rgba,
        )
    return (item,)


def _shape(values: Namespace, name: str) -> tuple[str, Namespace]:
    """Return the kind of an object's only shape, and what is said of it."""
    kinds = [kind for kind in _KINDS if values.find(kind) is not None]
    if len(kinds) != 1:
        raise ConfigError(
            f"object '{name}' has {' and '.join(kinds) or 'no shape'}; "
            f"give it one of {', '.join(_KINDS)}",
            values.location,
        )
    (kind,) = kinds
    shape = values.namespace(kind)
    assert shape is not None  # it was just found
    return kind, shape


def _box(shape: Namespace) -> Box:
    shape.only("size")
    return Box(size=shape.vector("size"))


def _cylinder(shape: Namespace) -> Cylinder:
    shape.only("radius", "length")
    return Cylinder(radius=shape.number("radius"), length=shape.number("length"))


def _sphere(shape: Namespace) -> Sphere:
    shape.only("radius")
    return Sphere(radius=shape.number("radius"))


def _mesh(shape: Namespace) -> Mesh:
    shape.only("file", "scale")
    uri = shape.text("file")
    location = (shape.find("file") or shape.entry).location
    try:
        path = find_mesh(uri, location)
    except DescriptionError as error:
        raise ConfigError(error.message, location) from None
    return Mesh(
        uri=uri, path=path.absolute(), scale=shape.vector("scale", (1.0, 1.0, 1.0))
    )


_SHAPES: dict[str, Callable[[Namespace], Geometry]] = {
    "box": _box,
    "cylinder": _cylinder,
    "sphere": _sphere,
    "mesh": _mesh,
}
_BIN = "bin"
_KINDS = (*_SHAPES, _BIN)


def _pose(values: Namespace) -> Pose:
    pose = values.namespace("pose")
    if pose is None:
        return Pose()
    pose.only("xyz", "rpy")
    zero = (0.0, 0.0, 0.0)
    return Pose(xyz=pose.vector("xyz", zero), rpy=pose.vector("rpy", zero))


@contextmanager
def _located(entry: Entry) -> Iterator[None]:
    """Add where ``entry`` stands to an error that does not say where."""
    try:
        yield
    except ConfigError as error:
        if error.location is not None:
            raise
        raise ConfigError(error.message, entry.location) from None
