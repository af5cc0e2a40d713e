"""Several robots of the catalogue as one model: expanded one by one, then merged."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tool0.description.cell_file import load_cell, parse_robots
from tool0.description.config import Cell, CellRobot, DescriptionConfig
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import RobotModel
from tool0.description.robot import CatalogueRobot, RobotDescription, expand_robot
from tool0.description.shapes import Box, Cylinder, Solid, Sphere
from tool0.description.transform import Transform, to_transform
from tool0.description.urdf import read_model
from tool0.description.xml_source import children, parse_text
from tool0.errors import ConfigError, DescriptionError

if TYPE_CHECKING:
    from xml.dom.minidom import Document, Element

WORLD = "world"
"""The link that carries every robot of a cell."""


def load_cell_description(
    config: DescriptionConfig, spawn_z: float
) -> RobotDescription:
    """Return the robots of the cell that ``config`` names as one model.

    Raises:
        ConfigError: If the cell is wrong, or two bases overlap.
        DescriptionError: If a name, an argument or a file of a robot is wrong.
        ModelError: If the parameters are physically impossible.
    """
    cell = _cell(config)
    robots, documents = [], []
    for item in cell.robots:
        try:
            robot, document = expand_robot(item.description, spawn_z, item.name)
        except DescriptionError as error:
            location = error.location or item.location
            message = f"robot '{item.name}': {error.message}"
            raise DescriptionError(message, location) from None
        robots.append(robot)
        documents.append(document)
    model_name = cell.name or "_".join(
        [*(robot.prefix + robot.arm.name for robot in robots), "robot"]
    )
    document = _merged(model_name, cell, documents)
    model = read_model(document)
    _check_bases(cell, model)
    file = cell.location.file if cell.location else None
    return RobotDescription(
        model=model,
        source=file or Path(model_name),
        robots=tuple(robots),
        cell=cell,
        _document=document,
    )


def _cell(config: DescriptionConfig) -> Cell:
    if config.robots is not None:
        return parse_robots(config.robots)
    assert config.cell is not None
    return config.cell if isinstance(config.cell, Cell) else load_cell(config.cell)


def _merged(name: str, cell: Cell, documents: Sequence[Document]) -> Document:
    """Return one URDF with the elements of all, below one link ``world``.

    Raises:
        ConfigError: If two robots have a link or a joint of one name.
    """
    merged = parse_text("<robot/>")
    root = _root(merged)
    root.setAttribute("name", name)
    owners: dict[tuple[str, str], CellRobot] = {}
    for robot, document in zip(cell.robots, documents, strict=True):
        for element in list(children(_root(document))):
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
            root.appendChild(element)
    return merged


def _root(document: Document) -> Element:
    assert document.documentElement is not None
    return document.documentElement


# ---- overlapping bases ---------------------------------------------------------------


class _Footprint(NamedTuple):
    """The vertical cylinder around what a base occupies, in the world."""

    x: float
    y: float
    radius: float
    low: float
    high: float


def _check_bases(cell: Cell, model: RobotModel) -> None:
    """Raise ConfigError if bases or pedestals of two robots overlap."""
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
    """Return the space of the shapes that are fixed to a robot's base."""
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
    """Return half the horizontal and the vertical size of a solid [m], at most."""
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
    return 0.0, 0.0  # a mesh: its size is not known without reading it
