"""Centre of mass and inertia of solid shapes, which Gazebo does not compute."""

from __future__ import annotations

import itertools
import struct
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere
from tool0.errors import ModelError

Array = np.ndarray


@final
@dataclass(frozen=True, slots=True)
class UnitInertia:
    """The inertia of a homogeneous solid of 1 kg."""

    center: Array
    """Of mass, shape (3,) [m]."""
    tensor: Array
    """Of inertia about it, shape (3, 3) [m²]."""


def unit_inertia(geometry: Geometry) -> UnitInertia:
    """Return the inertia of a solid of that shape.

    Raises:
        ModelError: If it is a mesh that cannot be read or encloses nothing.
    """
    match geometry:
        case Box(size=(x, y, z)):
            return _centred(y * y + z * z, x * x + z * z, x * x + y * y, over=12.0)
        case Cylinder(radius=r, length=length):
            across = 3.0 * r * r + length * length
            return _centred(across, across, 6.0 * r * r, over=12.0)
        case Sphere(radius=r):
            return _centred(r * r, r * r, r * r, over=2.5)
        case Mesh(path=path, scale=scale):
            return _enclosed(_triangles(path) * np.asarray(scale), path)


def check_mesh(path: Path) -> None:
    """Raise ModelError unless the file is a mesh; Gazebo would silently ignore it.

    Of a COLLADA file only the XML is checked: a broken one would end gzserver.
    """
    if path.suffix.lower() != ".dae":
        _triangles(path)
        return
    try:
        ET.parse(path)
    except (OSError, ET.ParseError) as error:
        raise ModelError(f"cannot read the mesh {path}: {error}") from None


def _centred(*moments: float, over: float) -> UnitInertia:
    return UnitInertia(np.zeros(3), np.diag(moments) / over)


def _enclosed(triangles: Array, path: Path) -> UnitInertia:
    """Return what the triangles, shape (n, 3, 3), enclose.

    The sum of the tetrahedra between each triangle and the origin, with their signs:
    F. Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia tensor" (2004).
    """
    sixfold = np.linalg.det(triangles)  # volumes
    volume = sixfold.sum() / 6.0
    extent = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    if not abs(volume) > 1e-9 * extent**3:
        raise ModelError(
            f"the mesh {path} encloses nothing, so its mass has no place; "
            "close its surface, or leave the mass out"
        )
    sums = triangles.sum(axis=1)
    center = sixfold @ sums / 24.0 / volume
    second = np.einsum("n,nki,nkj->ij", sixfold, triangles, triangles)
    second += np.einsum("n,ni,nj->ij", sixfold, sums, sums)
    spread = second / 120.0 / volume - np.outer(center, center)
    return UnitInertia(center, np.trace(spread) * np.eye(3) - spread)


def _triangles(path: Path) -> Array:
    """Return the triangles of an STL or OBJ file, shape (n, 3, 3)."""
    read = {".stl": _read_stl, ".obj": _read_obj}.get(path.suffix.lower())
    if read is None:
        raise ModelError(
            f"cannot read the mesh {path}: use STL or OBJ; what stands still may be DAE"
        )
    try:
        triangles = read(path.read_bytes())
    except (OSError, ValueError, IndexError, struct.error) as error:
        raise ModelError(f"cannot read the mesh {path}: {error}") from None
    if not len(triangles):
        raise ModelError(f"the mesh {path} has no triangles")
    return triangles


def _read_stl(data: bytes) -> Array:
    """Read binary STL, whose size tells it apart, or the text that means the same."""
    header, record = 84, 50  # [bytes]: name and count; normal, corners, two spare
    count = struct.unpack_from("<I", data, 80)[0] if len(data) >= header else -1
    if len(data) != header + record * count:
        words = data.decode(errors="replace").split()
        corners = [
            [float(word) for word in words[i + 1 : i + 4]]
            for i, word in enumerate(words)
            if word == "vertex"
        ]
        return np.array(corners).reshape(-1, 3, 3)
    kind = np.dtype(
        [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")]
    )
    return np.frombuffer(data, kind, offset=header)["corners"].astype(float)


def _read_obj(data: bytes) -> Array:
    vertices: list[list[float]] = []
    triangles: list[list[list[float]]] = []
    for line in data.decode(errors="replace").splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            vertices.append([float(part) for part in rest[:3]])
        elif word == "f":
            numbers = [int(part.partition("/")[0]) for part in rest]
            corners = [vertices[n - 1 if n > 0 else n] for n in numbers]
            fan = itertools.pairwise(corners[1:])
            triangles.extend([corners[0], second, third] for second, third in fan)
    return np.array(triangles).reshape(-1, 3, 3)
