"""Shapes of links and objects, and their mesh files."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import final

from tool0.description.packages import resolve_uri
from tool0.description.transform import Pose, Vector3
from tool0.description.units import require_plausible_size
from tool0.errors import ConfigError, DescriptionError, SourceLocation

MESH_SUFFIXES = (".dae", ".obj", ".stl")
MOST_MESH_BYTES = 100_000_000
_STL_HEADER, _STL_TRIANGLE = 84, 50
"""Sizes in a binary STL file [bytes].  The first size is that of the header, including
the number of triangles.  The second size is that of one triangle, which consists of a
normal, three corners and two unused bytes."""
_STL_TRAILER = 1024
"""Number of bytes that are accepted after the triangles, since some programs append
data."""
SHAPES = ("box", "cylinder", "sphere", "mesh")

RGBA = tuple[float, float, float, float]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A box, centered at its origin."""

    size: Vector3
    """Full edge lengths along x, y and z [m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Cylinder:
    """A cylinder along the z axis, centered at the origin."""

    radius: float
    """Radius of the cylinder [m]."""
    length: float
    """Length of the cylinder along z [m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Sphere:
    """A sphere, centered at its origin."""

    radius: float
    """Radius of the sphere [m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Mesh:
    """A mesh that the function ``mesh`` reads from a file."""

    uri: str
    """URI of the file, as written in the source: ``package://…``, ``file://…`` or a
    path."""
    path: Path
    """Existing file to which the URI resolves."""
    scale: Vector3 = (1.0, 1.0, 1.0)
    """Factors that convert the numbers in the file to meters, along x, y and z."""


Geometry = Box | Cylinder | Sphere | Mesh


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Compound:
    """Several shapes of the same density that form one rigid body.

    Where two shapes overlap, the masses of both shapes are added.
    """

    parts: tuple[tuple[Geometry, Pose], ...]
    """Shapes of the body, and the pose of each shape in the body's frame."""

    def __post_init__(self) -> None:
        try:
            is_valid = bool(self.parts) and all(
                isinstance(shape, Geometry) and isinstance(pose, Pose)
                for shape, pose in self.parts
            )
        except (TypeError, ValueError):
            is_valid = False
        if not is_valid or not isinstance(self.parts, tuple):
            raise ConfigError(
                "the parts of a compound are a tuple of (shape, Pose) pairs, at least "
                f"one, got {self.parts!r:.80}"
            )


Solid = Geometry | Compound
"""Shape of an object: a single shape, or a compound of several shapes."""


def placed_geometries(solid: Solid) -> tuple[tuple[Geometry, Pose], ...]:
    """Return the shapes of an object, and the shapes' poses in the object's frame."""
    return solid.parts if isinstance(solid, Compound) else ((solid, Pose()),)


def geometry_names(name: str, solid: Solid) -> tuple[str, ...]:
    """Return a name for each part as in Gazebo: ``name``, ``name_1`` and so on."""
    count = len(placed_geometries(solid))
    return (name, *(f"{name}_{number}" for number in range(1, count)))


def read_geometry(
    kind: str,
    numbers: Callable[..., tuple[float, ...]],
    uri: Callable[[], tuple[str, SourceLocation | None]],
) -> Geometry:
    """Return the shape of a kind in ``SHAPES`` without checking its sizes.

    Args:
        kind: The kind of shape.
        numbers: Function that reads ``size``, ``radius``, ``length`` or ``scale`` from
            attributes, child elements or YAML values.  The function's arguments are the
            name, the number of values and an optional default.
        uri: Function that returns the URI of a mesh, and the source location of the
            URI.

    Raises:
        DescriptionError: If a mesh file is missing or its format is not supported.
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
    """Return the sizes of a shape [m], or the scale of a mesh."""
    match geometry:
        case Box(size=size):
            return size
        case Cylinder(radius=radius, length=length):
            return radius, length
        case Sphere(radius=radius):
            return (radius,)
        case Mesh(scale=scale):
            return scale


def kind_of(solid: Solid) -> Solid | type[Geometry]:
    """Return the type of a box, cylinder or sphere; return other shapes unchanged.

    Two shapes with equal results differ only in their ``sizes``.
    """
    return type(solid) if isinstance(solid, Box | Cylinder | Sphere) else solid


def resized(geometry: Solid, values: Sequence[float]) -> Geometry:
    """Return a box, cylinder or sphere with new ``sizes`` [m].

    Raises:
        ConfigError: If the shape is a mesh or a compound, or the number of sizes is
            wrong.
    """
    match geometry, tuple(values):
        case Box(), (x, y, z):
            return Box(size=(x, y, z))
        case Cylinder(), (radius, length):
            return Cylinder(radius=radius, length=length)
        case Sphere(), (radius,):
            return Sphere(radius=radius)
    kind = type(geometry).__name__.lower()
    raise ConfigError(
        f"a {kind} cannot get {len(values)} sizes; a box has 3 (x, y, z), a cylinder 2 "
        "(radius, length), a sphere 1 (radius), and other shapes have none"
    )


def extents(geometry: Geometry) -> Vector3:
    """Return the edges of the box that bounds a shape [m], in the shape's axes.

    Raises:
        ConfigError: If the shape is a mesh, since its size is stated only in the file.
    """
    match geometry:
        case Box(size=size):
            return size
        case Cylinder(radius=radius, length=length):
            return 2.0 * radius, 2.0 * radius, length
        case Sphere(radius=radius):
            return 2.0 * radius, 2.0 * radius, 2.0 * radius
        case Mesh(uri=uri):
            raise ConfigError(f"the extents of the mesh '{uri}' are those of its file")


def check_solid(solid: Solid, of: str, *, is_fixed: bool) -> None:
    """Raise ConfigError, stating the owner ``of``, unless sizes and poses are valid."""
    if not isinstance(solid, Compound):
        check_geometry(solid, of)
        _check_scale(solid, of, is_fixed=is_fixed)
        return
    for number, (geometry, pose) in enumerate(solid.parts, start=1):
        check_geometry(geometry, f"of shape {number} {of}")
        _check_scale(geometry, f"of shape {number} {of}", is_fixed=is_fixed)
        if not all(map(math.isfinite, (*pose.xyz, *pose.rpy))):
            raise ConfigError(
                f"the pose of shape {number} {of} must be finite, got {pose}"
            )


def check_geometry(geometry: Geometry, of: str) -> None:
    """Raise ConfigError, stating the owner ``of``, unless the sizes are valid."""
    kind = type(geometry).__name__.lower()
    try:
        values = tuple(float(x) for x in sizes(geometry) if isinstance(x, Real))
        is_number = len(values) == len(sizes(geometry))
    except (TypeError, OverflowError):
        is_number = False
    if not is_number:
        raise ConfigError(
            f"the sizes of the {kind} {of} must be numbers, got {sizes(geometry)!r:.80}"
        )
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


def _check_scale(geometry: Geometry, of: str, *, is_fixed: bool) -> None:
    """Raise ConfigError if the sizes are implausible in meters."""
    # The unit of a mesh file is arbitrary and is defined by its scale.
    if isinstance(geometry, Mesh):
        return
    edges = extents(geometry)
    what = f"the {type(geometry).__name__.lower()} {of}"
    require_plausible_size(edges, what, is_fixed=is_fixed)


def _find_mesh(uri: str, location: SourceLocation | None) -> Path:
    """Return the file of a mesh, or raise DescriptionError at ``location``."""
    path = resolve_uri(uri, location)
    if path.suffix.lower() not in MESH_SUFFIXES:
        raise DescriptionError(
            f"the format of the mesh '{uri}' is not supported; convert it to one of "
            f"{', '.join(MESH_SUFFIXES)}",
            location,
        )
    if not path.is_file():
        raise DescriptionError(
            f"there is no mesh '{path}' (written '{uri}'); check the path", location
        )
    problem = _size_problem(path)
    if problem:
        raise DescriptionError(f"the mesh '{path}' {problem}", location)
    return path.absolute()


def _size_problem(path: Path) -> str:
    """Return the problem with the size of a mesh file, or an empty text.

    The check reads only the header of the file.
    """
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            header = file.read(_STL_HEADER)
    except OSError as error:
        return f"cannot be read: {error.strerror}"
    if size > MOST_MESH_BYTES:
        limit = MOST_MESH_BYTES // 10**6
        return f"has {size / 1e6:,.0f} MB; use one of at most {limit} MB"
    is_text = header.startswith(b"solid")
    if path.suffix.lower() != ".stl" or is_text or len(header) < _STL_HEADER:
        return ""
    (count,) = struct.unpack_from("<I", header, _STL_HEADER - 4)
    needed = _STL_HEADER + _STL_TRIANGLE * count
    if needed <= size <= needed + _STL_TRAILER:
        return ""
    return (
        f"is no binary STL: its header says {count:,} triangles, which take "
        f"{needed:,} bytes, and the file has {size:,}"
    )


def mesh(file: Path | str, scale: float | Vector3 = 1.0) -> Mesh:
    """Return the shape in an STL or OBJ file.

    ``file`` is a path, or a URI that starts with ``package://`` or ``file://``.
    ``scale`` converts the lengths in the file to [m]; for example, 0.001 is the scale
    for mm.  ``scale`` is one number, or one number per axis.

    Raises:
        DescriptionError: If the file is missing or its format is not supported.
    """
    three = (scale, scale, scale) if isinstance(scale, (int, float)) else scale
    return Mesh(uri=str(file), path=_find_mesh(str(file), None), scale=three)
