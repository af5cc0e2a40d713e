"""A scene's YAML file, read into values.

The keys are those of ``SceneObject``, but that the geometry goes by its kind::

    objects:
      - {name: table, box: {size: [0.6, 0.8, 0.04]}, pose: {xyz: [0.6, 0, 0]}}
      - {name: can, cylinder: {radius: 0.03, length: 0.1}, mass: 0.2, friction: 0.6}
      - {name: part, mesh: {file: part.stl, scale: [0.001, 0.001, 0.001]}, mass: 0.1}
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tool0.description.mesh_files import find_mesh
from tool0.description.model import Box, Cylinder, Geometry, Mesh, Pose, Sphere
from tool0.description.scene import (
    DEFAULT_FRICTION,
    RGBA,
    Scene,
    SceneObject,
    check_geometry,
)
from tool0.description.yaml_tree import Entry, read_files
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, DescriptionError, SourceLocation

STILL_RGBA: RGBA = (0.78, 0.74, 0.66, 1.0)
"""Of what stands still and names no colour: pale wood."""
PALETTE: tuple[RGBA, ...] = (
    (0.90, 0.60, 0.00, 1.0),  # orange
    (0.00, 0.62, 0.45, 1.0),  # bluish green
    (0.80, 0.47, 0.65, 1.0),  # reddish purple
    (0.94, 0.89, 0.26, 1.0),  # yellow
    (0.84, 0.37, 0.00, 1.0),  # vermilion
    (0.00, 0.45, 0.70, 1.0),  # blue
)
"""Of movable objects that name no colour, in turn: told apart by colour-blind people
too (Okabe and Ito, https://jfly.uni-koeln.de/color/)."""


def load_scene(path: Path | str) -> Scene:
    """Return the objects in a YAML file; none, if it is empty.

    Raises:
        ConfigError: If anything in it is wrong, with file and line.
    """
    tree = read_files([Path(path).expanduser()])
    for finding in tree.findings:  # no later key may hide an earlier one
        raise ConfigError(
            f"'{finding.key}' stands twice; {finding.remedy}", finding.location
        )
    root = Namespace(tree.root)
    root.only("objects")
    colors = itertools.cycle(PALETTE)
    objects: dict[str, SceneObject] = {}
    locations: dict[str, SourceLocation] = {}
    for entry in root.items("objects"):
        item = _object(entry, colors)
        if item.name in objects:
            raise ConfigError(
                f"two objects are called '{item.name}', the other at "
                f"{locations[item.name]}; rename one",
                entry.location,
            )
        objects[item.name], locations[item.name] = item, entry.location
    return Scene(tuple(objects.values()), locations)


def _object(entry: Entry, colors: Iterator[RGBA]) -> SceneObject:
    values = Namespace.of(entry)
    values.only("name", "pose", "mass", "friction", "rgba", *_SHAPES)
    mass = values.number("mass") if values.find("mass") is not None else None
    if values.find("rgba") is not None:
        red, green, blue, alpha = values.numbers("rgba", 4)
        rgba = (red, green, blue, alpha)
    else:
        rgba = STILL_RGBA if mass is None else next(colors)
    name = values.text("name")
    geometry = _geometry(values, name)
    with _located(entry):
        return SceneObject(
            name=name,
            geometry=geometry,
            pose=_pose(values),
            mass=mass,
            friction=values.number("friction", DEFAULT_FRICTION),
            rgba=rgba,
        )


def _geometry(values: Namespace, name: str) -> Geometry:
    kinds = [kind for kind in _SHAPES if values.find(kind) is not None]
    if len(kinds) != 1:
        raise ConfigError(
            f"object '{name}' has {' and '.join(kinds) or 'no shape'}; "
            f"give it one of {', '.join(_SHAPES)}",
            values.location,
        )
    (kind,) = kinds
    shape = values.namespace(kind)
    assert shape is not None  # it was just found
    geometry = _SHAPES[kind](shape)
    with _located(shape.entry):
        check_geometry(geometry, f"of object '{name}'")
    return geometry


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
