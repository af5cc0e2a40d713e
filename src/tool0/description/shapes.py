"""Shapes of links and objects, and the mesh files that some of them come from."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import final

from tool0.description.packages import resolve_uri
from tool0.description.transform import Vector3
from tool0.errors import ConfigError, DescriptionError, SourceLocation

MESH_SUFFIXES = (".dae", ".obj", ".stl")
SHAPES = ("box", "cylinder", "sphere", "mesh")

RGBA = tuple[float, float, float, float]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    size: Vector3
    """Full edge lengths."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Cylinder:
    """A cylinder about z, centred at its origin."""

    radius: float
    length: float


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Sphere:
    radius: float


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Mesh:
    uri: str
    """As written: ``package://…``, ``file://…`` or a path."""
    path: Path
    """The file it resolves to; it exists."""
    scale: Vector3 = (1.0, 1.0, 1.0)


Geometry = Box | Cylinder | Sphere | Mesh


def read_geometry(
    kind: str,
    numbers: Callable[..., tuple[float, ...]],
    uri: Callable[[], tuple[str, SourceLocation | None]],
) -> Geometry:
    """Return the shape of a kind in ``SHAPES``, its sizes unchecked.

    Args:
        kind: Its kind.
        numbers: Reads ``size``, ``radius``, ``length`` or ``scale``, by name, count and
            an optional default: attributes, child elements or YAML values.
        uri: Returns the URI of a mesh, and where it is written.

    Raises:
        DescriptionError: If a mesh is not there, or of a kind that nothing reads.
    """
    if kind == "box":
        x, y, z = numbers("size", 3)
        return Box(size=(x, y, z))
    if kind == "mesh":
        text, location = uri()
        x, y, z = numbers("scale", 3, (1.0, 1.0, 1.0))
        return Mesh(uri=text, path=_find_mesh(text, location), scale=(x, y, z))
    (radius,) = numbers("radius", 1)
    if kind == "sphere":
        return Sphere(radius=radius)
    (length,) = numbers("length", 1)
    return Cylinder(radius=radius, length=length)


def sizes(geometry: Geometry) -> tuple[float, ...]:
    """Return all sizes of a shape [m]; of a mesh, its scale."""
    match geometry:
        case Box(size=size):
            return size
        case Cylinder(radius=radius, length=length):
            return radius, length
        case Sphere(radius=radius):
            return (radius,)
        case Mesh(scale=scale):
            return scale


def check_geometry(geometry: Geometry, of: str) -> None:
    """Raise ConfigError unless its sizes are possible; ``of`` names its owner."""
    values = sizes(geometry)
    kind = type(geometry).__name__.lower()
    if isinstance(geometry, Box) and len(values) != 3:
        raise ConfigError(f"the box {of} has three edges, got {len(values)}")
    if isinstance(geometry, Mesh):
        if not all(math.isfinite(part) and part for part in values):
            raise ConfigError(
                f"the scale of the mesh {of} must be finite and never 0, got {values}"
            )
    elif not all(0.0 < size < math.inf for size in values):
        got = ", ".join(f"{size:g}" for size in values)
        raise ConfigError(
            f"each size of the {kind} {of} must be above 0 m and finite, got {got}"
        )


def _find_mesh(uri: str, location: SourceLocation | None) -> Path:
    """Return the file of a mesh, or raise DescriptionError at ``location``."""
    path = resolve_uri(uri, location)
    if path.suffix.lower() not in MESH_SUFFIXES:
        raise DescriptionError(
            f"nothing reads the mesh '{uri}'; convert it to one of "
            f"{', '.join(MESH_SUFFIXES)}",
            location,
        )
    if not path.is_file():
        raise DescriptionError(
            f"there is no mesh '{path}' (written '{uri}'); check the path", location
        )
    return path.absolute()


def mesh(file: Path | str, scale: float | Vector3 = 1.0) -> Mesh:
    """Return the shape in a file, STL or OBJ: a path, ``package://`` or ``file://``.

    Its lengths times ``scale``, for all or each direction, are [m]: 0.001 for mm.

    Raises:
        DescriptionError: If it is not there, or of a kind that nothing reads.
    """
    three = (scale, scale, scale) if isinstance(scale, (int, float)) else scale
    return Mesh(uri=str(file), path=_find_mesh(str(file), None), scale=three)
