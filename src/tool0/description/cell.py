"""Merging of a cell's robots into one model, and checks for overlapping bases."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from tool0.description.config import Cell, CellRobot
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import RobotModel
from tool0.description.shapes import Box, Cylinder, Solid, Sphere
from tool0.description.transform import Transform, to_transform
from tool0.description.xml_source import children, parse_text
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from xml.dom.minidom import Document, Element

WORLD = "world"
"""Name of the link that carries all robots of a cell."""


def merge_robots(cell: Cell, name: str, documents: Sequence[Document]) -> Document:
    """Return one URDF, called ``name``, with the elements of all robots' URDFs.

    All robots share the link ``world``.  The robots' documents are not changed.

    Raises:
        ConfigError: If two robots have a link or joint with the same name.
    """
    merged = parse_text("<robot/>")
    root = _root(merged)
    root.setAttribute("name", name)
    owners: dict[tuple[str, str], CellRobot] = {}
    for robot, document in zip(cell.robots, documents, strict=True):
        for element in children(_root(document)):
            key = (element.tagName, element.getAttribute("name"))
            if key == ("link", WORLD) and key in owners:
                continue
            if key[0] in ("link", "joint"):
                owner = owners.setdefault(key, robot)
                if owner is not robot:
                    raise ConfigError(
                        f"robots '{owner.name}' and '{robot.name}' both have a "
                        f"{key[0]} '{key[1]}'; rename one of the two robots",
                        robot.location,
                    )
            copy = element.cloneNode(True)
            assert copy is not None
            root.appendChild(copy)
    return merged


def _root(document: Document) -> Element:
    assert document.documentElement is not None
    return document.documentElement


# ---- overlapping bases ---------------------------------------------------------------


class _Footprint(NamedTuple):
    """Vertical cylinder that encloses the space occupied by a base, in the world."""

    x: float
    y: float
    radius: float
    low: float
    high: float


def check_bases(cell: Cell, model: RobotModel) -> None:
    """Raise ConfigError if the bases or pedestals of two robots overlap."""
    found = [(robot, _footprint(model, robot.prefix)) for robot in cell.robots]
    for (first, a), (second, b) in itertools.combinations(found, 2):
        distance, needed = math.hypot(a.x - b.x, a.y - b.y), a.radius + b.radius
        if distance < needed and a.low < b.high and b.low < a.high:
            raise ConfigError(
                f"the bases of '{first.name}' and '{second.name}' overlap: they are "
                f"{distance:.3f} m apart and need {needed:.3f} m; move one",
                second.location,
            )


def _footprint(model: RobotModel, prefix: str) -> _Footprint:
    """Return the space occupied by the shapes that are fixed to a robot's base."""
    poses = link_poses(model, {joint.name: 0.0 for joint in model.movable_joints})
    base = f"{prefix}base_link"
    x, y, z = poses[base].position
    radius, low, high = 0.0, z, z
    for link in _fixed_below(model, base):
        for shape in model.link(link).collisions:
            T = poses[link] @ to_transform(shape.origin)
            dx, dy, dz = (a - b for a, b in zip(T.position, (x, y, z), strict=True))
            across, up = _half_extents(shape.geometry, T)
            radius = max(radius, math.hypot(dx, dy) + across)
            low, high = min(low, z + dz - up), max(high, z + dz + up)
    return _Footprint(x, y, radius, low, high)


def _fixed_below(model: RobotModel, link: str) -> list[str]:
    found = [link]
    for joint in model.child_joints[link]:
        if not joint.is_movable:
            found += _fixed_below(model, joint.child)
    return found


def _half_extents(solid: Solid, T: Transform) -> tuple[float, float]:
    """Return upper bounds on half the width and half the height of a solid [m]."""
    match solid:
        case Sphere(radius=radius):
            return radius, radius
        case Cylinder(radius=radius, length=length):
            upright = min(1.0, abs(T.rotation[2][2]))
            tilt = math.sqrt(1.0 - upright * upright)
            half = length / 2.0
            return radius + half * tilt, half * upright + radius * tilt
        case Box(size=size):
            half = math.hypot(*size) / 2.0
            return half, half
    return 0.0, 0.0  # the size of a mesh is unknown without reading its file
