"""Shapes of links and objects, and the mesh files that some of them come from."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import final

from tool0.description.packages import resolve_uri
from tool0.description.transform import Vector3
from tool0.errors import ConfigError, DescriptionError, SourceLocation

MESH_SUFFIXES = (".dae", ".obj", ".stl")


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


def check_geometry(geometry: Geometry, of: str) -> None:
    """Raise ConfigError unless its sizes are possible; ``of`` names its owner."""
    match geometry:
        case Box(size=size):
            if len(size) != 3:
                raise ConfigError(f"the box {of} has three edges, got {len(size)}")
            _check_sizes("each edge of the box", of, size)
        case Cylinder(radius=radius, length=length):
            _check_sizes("radius and length of the cylinder", of, (radius, length))
        case Sphere(radius=radius):
            _check_sizes("the radius of the sphere", of, (radius,))
        case Mesh(scale=scale):
            if not all(math.isfinite(part) and part for part in scale):
                raise ConfigError(
                    f"the scale of the mesh {of} must be finite and never 0, "
                    f"got {scale}"
                )


def _check_sizes(what: str, of: str, sizes: Iterable[float]) -> None:
    if not all(0.0 < size < math.inf for size in sizes):
        got = ", ".join(f"{size:g}" for size in sizes)
        raise ConfigError(f"{what} {of} must be above 0 m and finite, got {got}")


def find_mesh(uri: str, location: SourceLocation | None) -> Path:
    """Return the file of a mesh.

    Args:
        uri: ``package://``, ``file://`` or a path.
        location: Where it is written, for messages.

    Raises:
        DescriptionError: If it is not there, or of a kind that nothing reads.
    """
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
    return path


def mesh(file: Path | str, scale: float | Vector3 = 1.0) -> Mesh:
    """Return the shape in a file, STL or OBJ.

    Args:
        file: Its path, or ``package://``, ``file://``.
        scale: What its lengths are multiplied by to be [m], in all or each direction:
            0.001 for millimetres.

    Raises:
        DescriptionError: If it is not there, or of a kind that nothing reads.
    """
    path = find_mesh(str(file), None).absolute()
    three = (scale, scale, scale) if isinstance(scale, (int, float)) else scale
    return Mesh(uri=str(file), path=path, scale=three)
