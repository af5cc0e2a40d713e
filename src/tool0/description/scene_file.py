"""Reader of scenes in YAML files, and the list of built-in scenes.

The keys are those of ``SceneObject`` and ``Camera``, with two differences.  The key of
a shape is its kind, and a camera's pose can contain the point at which the camera
looks::

    objects:
      - {name: table, box: {size: [0.6, 0.8, 40mm]}, pose: {xyz: [0.6, 0, 0]}}
      - {name: can, cylinder: {radius: 0.03, length: 0.1}, mass: 0.2, friction: 0.6}
      - {name: part, mesh: {file: part.stl, scale: [0.001, 0.001, 0.001]}, mass: 0.1}
      - {name: tray, bin: {size: [0.3, 0.2, 0.1], wall: 0.004}}
      - name: mug  # one rigid body; each shape has a pose in it
        mass: 0.3
        shapes:
          - {cylinder: {radius: 0.04, length: 0.1}}
          - {box: {size: [0.03, 0.01, 0.06]}, pose: {xyz: [0.055, 0, 0]}}
    cameras:
      - {name: above, pose: {xyz: [0.5, 0, 1.2], look_at: [0.5, 0, 0], up: [1, 0, 0]}}
      - {name: palm, link: tool0, pose: {xyz: [0, 0, 0.1], rpy: [0, 0, 0]}, far: 2}

A bin is a fixed open box.  The bin is converted to five objects, such as ``tray.floor``
and ``tray.front``.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, TypeVar

from tool0.description.camera import Camera, looking
from tool0.description.scene import (
    DEFAULT_FRICTION,
    DEFAULT_WALL,
    PALETTE,
    STILL_RGBA,
    Scene,
    SceneObject,
    bin_walls,
)
from tool0.description.shapes import (
    RGBA,
    SHAPES,
    Compound,
    Geometry,
    check_geometry,
    read_geometry,
)
from tool0.description.transform import Pose
from tool0.description.units import ANGLE, LENGTH, Quantity
from tool0.description.yaml_tree import YamlEntry, read_mapping
from tool0.description.yaml_values import Namespace
from tool0.errors import (
    ConfigError,
    DescriptionError,
    SourceLocation,
    did_you_mean,
)
from tool0.user_data import expanded

Item = TypeVar("Item", SceneObject, Camera)

SCENE_FOLDER = Path(__file__).resolve().parent.parent / "scenes"

_ZERO = (0.0, 0.0, 0.0)
_BIN = "bin"
_SEVERAL = "shapes"
_KINDS = (*SHAPES, _BIN, _SEVERAL)
_SHAPE_KEYS = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "mesh": ("file", "scale"),
    _BIN: ("size", "wall"),
}
_CAMERA_NUMBERS: Final[Mapping[str, Quantity]] = {
    "field_of_view": ANGLE,
    "near": LENGTH,
    "far": LENGTH,
}
_CAMERA_PIXELS = ("width", "height")


def shipped_scenes() -> dict[str, Path]:
    """Return the files of the built-in scenes by name."""
    return {path.stem: path for path in sorted(SCENE_FOLDER.glob("*.yaml"))}


def scene_path(given: Path | str) -> Path:
    """Return the file of a scene, given by its path or by the name of a built-in scene.

    A file takes precedence over a built-in scene of the same name.

    Raises:
        ConfigError: If ``given`` is a plain name, and neither a file nor a built-in
            scene has this name.
    """
    path = expanded(given)
    if path.suffix or path.name != str(given) or path.is_file():
        return path
    shipped = shipped_scenes()
    if path.name not in shipped:
        raise ConfigError(
            f"no scene '{path.name}'{did_you_mean(path.name, list(shipped))}; give a "
            f"YAML file, or a built-in one: {', '.join(shipped)}"
        )
    return shipped[path.name]


def load_scene(path: Path | str) -> Scene:
    """Return the objects in a YAML file, or in the built-in scene of this name.

    Raises:
        ConfigError: If the file contains a mistake.  The error states the file and the
            line.
    """
    return read_scene(read_mapping(scene_path(path)))


def read_scene(entry: YamlEntry) -> Scene:
    """Return the objects and cameras of a mapping, or raise ConfigError."""
    root = Namespace(entry)
    root.only("objects", "cameras")
    colors = itertools.cycle(PALETTE)
    objects, locations = _read_list(root, "objects", lambda e: _objects(e, colors))
    cameras, _ = _read_list(root, "cameras", lambda e: (_camera(e),))
    return Scene(objects, locations, cameras)


def _read_list(
    root: Namespace, kind: str, read: Callable[[YamlEntry], tuple[Item, ...]]
) -> tuple[tuple[Item, ...], dict[str, SourceLocation]]:
    """Return the items in a list, and the source location of each item's name."""
    found: list[Item] = []
    locations: dict[str, SourceLocation] = {}
    for entry in root.items(kind):
        for item in read(entry):
            if item.name in locations:
                raise ConfigError(
                    f"two {kind} are called '{item.name}', the other at "
                    f"{locations[item.name]}; rename one",
                    entry.location,
                )
            locations[item.name] = entry.location
            found.append(item)
    return tuple(found), locations


def _objects(entry: YamlEntry, colors: Iterator[RGBA]) -> tuple[SceneObject, ...]:
    """Return the objects that an entry describes: one, or the five parts of a bin."""
    values = Namespace(entry)
    values.only("name", "pose", "mass", "friction", "rgba", *_KINDS)
    mass = values.number("mass") if values.find("mass") is not None else None
    if values.find("rgba") is not None:
        red, green, blue, alpha = values.numbers("rgba", 4)
        rgba = (red, green, blue, alpha)
    else:
        rgba = STILL_RGBA if mass is None else next(colors)
    name = values.text("name")
    kind = _kind(values, _KINDS, f"object '{name}'")
    friction = values.number("friction", DEFAULT_FRICTION)
    if kind == _BIN:
        shape = _shape(values, kind)
        if mass is not None:
            raise ConfigError(f"bin '{name}' is fixed; omit its mass", entry.location)
        with _located(shape.entry):
            return bin_walls(
                name,
                size=shape.vector("size", None, LENGTH),
                wall=shape.number("wall", DEFAULT_WALL, LENGTH),
                pose=_pose(values),
                friction=friction,
                rgba=rgba,
            )
    of = f"of object '{name}'"
    geometry = (
        _compound(values, of) if kind == _SEVERAL else _geometry(kind, values, of)
    )
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


def _kind(values: Namespace, kinds: Sequence[str], owner: str) -> str:
    """Return the kind, out of ``kinds``, that is given, or raise ConfigError."""
    given = [kind for kind in kinds if values.find(kind) is not None]
    if len(given) != 1:
        raise ConfigError(
            f"{owner} has {' and '.join(given) or 'no shape'}; "
            f"give it one of {', '.join(kinds)}",
            values.location,
        )
    return given[0]


def _shape(values: Namespace, kind: str) -> Namespace:
    """Return the sizes of a shape [m]."""
    shape = values.namespace(kind) or values
    shape.only(*_SHAPE_KEYS[kind])
    return shape


def _compound(values: Namespace, of: str) -> Compound:
    """Return the list ``shapes`` as a compound in the object's frame."""
    parts = []
    for number, entry in enumerate(values.items(_SEVERAL), start=1):
        part = Namespace(entry)
        part.only("pose", *SHAPES)
        of_part = f"shape {number} {of}"
        kind = _kind(part, SHAPES, of_part)
        parts.append((_geometry(kind, part, f"of {of_part}"), _pose(part)))
    if not parts:
        location = (values.find(_SEVERAL) or values.entry).location
        raise ConfigError(f"the list 'shapes' {of} is empty; give shapes", location)
    return Compound(parts=tuple(parts))


def _geometry(kind: str, values: Namespace, of: str) -> Geometry:
    """Return the shape described by ``values``; errors state its owner, ``of``."""
    shape = _shape(values, kind)

    def numbers(
        name: str, count: int, default: tuple[float, ...] | None = None
    ) -> tuple[float, ...]:
        of = () if name == "scale" else (LENGTH,)
        if count == 1:
            return (shape.number(name, None, *of),)
        return shape.numbers(name, count, default, *of)

    def uri() -> tuple[str, SourceLocation]:
        return shape.text("file"), (shape.find("file") or shape.entry).location

    try:
        geometry = read_geometry(kind, numbers, uri)
    except DescriptionError as error:
        raise ConfigError(error.message, error.location) from None
    with _located(shape.entry):
        check_geometry(geometry, of)
    return geometry


def _camera(entry: YamlEntry) -> Camera:
    values = Namespace(entry)
    values.only("name", "link", "pose", *_CAMERA_PIXELS, *_CAMERA_NUMBERS)
    given: dict[str, Any] = {  # keyword arguments of two types
        **{
            key: values.number(key, None, quantity)
            for key, quantity in _CAMERA_NUMBERS.items()
            if values.find(key)
        },
        **{key: _pixels(values, key) for key in _CAMERA_PIXELS if values.find(key)},
    }
    with _located(entry):
        return Camera(
            name=values.text("name"),
            link=values.text("link") if values.find("link") else None,
            pose=_camera_pose(values),
            location=entry.location,
            **given,
        )


def _camera_pose(values: Namespace) -> Pose:
    pose = values.namespace("pose")
    if pose is None or pose.find("look_at") is None:
        return _pose(values, "look_at")
    pose.only("xyz", "look_at", "up")
    with _located(pose.entry):
        return looking(
            pose.vector("xyz", _ZERO, LENGTH),
            pose.vector("look_at", None, LENGTH),
            pose.vector("up", (0.0, 0.0, 1.0)),
        )


def _pixels(values: Namespace, key: str) -> int:
    value = values.number(key)
    if not value.is_integer():
        entry = values.find(key) or values.entry
        raise ConfigError(
            f"'{entry.key}' must be a whole number of pixels, got {value:g}",
            entry.location,
        )
    return int(value)


def _pose(values: Namespace, *other_keys: str) -> Pose:
    pose = values.namespace("pose")
    if pose is None:
        return Pose()
    pose.only("xyz", "rpy", *other_keys)
    with _located(pose.entry):
        return Pose(
            xyz=pose.vector("xyz", _ZERO, LENGTH), rpy=pose.vector("rpy", _ZERO, ANGLE)
        )


@contextmanager
def _located(entry: YamlEntry) -> Iterator[None]:
    """Add the location of ``entry`` to errors that have no location."""
    try:
        yield
    except ConfigError as error:
        if error.location is not None:
            raise
        raise ConfigError(error.message, entry.location) from None
