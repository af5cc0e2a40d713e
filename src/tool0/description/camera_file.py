"""The cameras of a scene's YAML file, read into values.

The keys are those of ``Camera``; its pose may say what to look at instead of how it is
turned, and by ``up`` what is to point up in the picture then::

    cameras:
      - {name: above, pose: {xyz: [0.5, 0, 1.2], look_at: [0.5, 0, 0], up: [1, 0, 0]}}
      - {name: palm, link: tool0, pose: {xyz: [0, 0, 0.1], rpy: [0, 0, 0]}, far: 2}
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from tool0.description.camera import Camera, looking
from tool0.description.model import Pose
from tool0.description.yaml_tree import Entry
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError

_NUMBERS = ("field_of_view", "near", "far")
_PIXELS = ("width", "height")


def read_cameras(entries: Iterable[Entry]) -> tuple[Camera, ...]:
    """Return the cameras that the elements of a list stand for.

    Raises:
        ConfigError: If anything is wrong, with file and line.
    """
    found: dict[str, Camera] = {}
    for entry in entries:
        camera = _camera(entry)
        if camera.name in found:
            raise ConfigError(
                f"two cameras are called '{camera.name}', the other at "
                f"{found[camera.name].location}; rename one",
                entry.location,
            )
        found[camera.name] = camera
    return tuple(found.values())


def _camera(entry: Entry) -> Camera:
    values = Namespace.of(entry)
    values.only("name", "link", "pose", *_PIXELS, *_NUMBERS)
    given: dict[str, Any] = {  # keywords of two types
        **{key: values.number(key) for key in _NUMBERS if values.find(key)},
        **{key: _count(values, key) for key in _PIXELS if values.find(key)},
    }
    name = values.text("name")
    link = values.text("link") if values.find("link") else None
    try:
        return Camera(
            name=name,
            link=link,
            pose=_pose(values),
            location=entry.location,
            **given,
        )
    except ConfigError as error:
        if error.location is not None:
            raise
        raise ConfigError(error.message, entry.location) from None


def _pose(values: Namespace) -> Pose:
    pose = values.namespace("pose")
    if pose is None:
        return Pose()
    zero = (0.0, 0.0, 0.0)
    if pose.find("look_at") is None:
        pose.only("xyz", "rpy", "look_at")
        return Pose(xyz=pose.vector("xyz", zero), rpy=pose.vector("rpy", zero))
    pose.only("xyz", "look_at", "up")
    try:
        return looking(
            pose.vector("xyz", zero),
            pose.vector("look_at"),
            pose.vector("up", (0.0, 0.0, 1.0)),
        )
    except ConfigError as error:
        if error.location is not None:
            raise
        raise ConfigError(error.message, pose.location) from None


def _count(values: Namespace, key: str) -> int:
    value = values.number(key)
    if not value.is_integer():
        entry = values.find(key) or values.entry
        raise ConfigError(
            f"'{entry.key}' must be a whole number of pixels, got {value:g}",
            entry.location,
        )
    return int(value)
