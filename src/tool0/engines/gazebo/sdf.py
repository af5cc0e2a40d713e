"""SDF models of scene objects, inertia of solids, and checks of the user's files."""

from __future__ import annotations

import itertools
import math
import struct
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from tool0.description.bodies import BodyInertia
from tool0.description.scene import SceneObject
from tool0.description.shapes import (
    Box,
    Compound,
    Cylinder,
    Geometry,
    Mesh,
    Solid,
    Sphere,
    geometry_names,
    placed_geometries,
)
from tool0.description.transform import Pose, pose_matrix
from tool0.errors import DescriptionError, ModelError, SourceLocation

Array = np.ndarray

STIFFNESS, DAMPING = 1e5, 10.0
"""Contact stiffness [N/m] and damping [N·s/m].  The values are the same as those of the
pads, so that objects at rest do not move."""
MIN_DEPTH, MAX_VEL = 1e-5, 0.1
"""Largest overlap that is not corrected [m], and largest speed of corrections [m/s].

The direct solver ignores the largest speed; preload.cc limits the speed instead.
"""
EMPTY_WORLD = Path(__file__).with_name("empty.world")
"""World file with a sun and with the ground at z = 0."""


def object_sdf(item: SceneObject) -> str:
    """Return the object as an SDF document, placed at the origin of its model.

    Raises:
        ModelError: If a mesh of the object cannot be read, or if the object has a mass
            and a mesh without volume.
    """
    parts = placed_geometries(item.geometry)
    for geometry, _ in parts:
        if isinstance(geometry, Mesh):
            check_mesh(geometry.path)
    names = [geometry_names(kind, item.geometry) for kind in ("collision", "visual")]
    shapes = "".join(
        _shape(item, collision, visual, *part)
        for collision, visual, part in zip(*names, parts, strict=True)
    )
    # Neither object names nor URIs contain characters that XML must escape.
    return f"""\
<sdf version="1.6">
  <model name="{item.name}">
    <static>{"false" if item.mass else "true"}</static>
    <link name="link">
      {_inertial(item)}
{shapes}    </link>
  </model>
</sdf>
"""


def _shape(
    item: SceneObject, collision: str, visual: str, geometry: Geometry, pose: Pose
) -> str:
    placed = " ".join(repr(float(part)) for part in (*pose.xyz, *pose.rpy))
    where = f"<pose>{placed}</pose>{_geometry(geometry)}"
    color = " ".join(map(repr, item.rgba))
    return f"""\
      <collision name="{collision}">
        {where}
        <surface>
          <friction><ode>
            <mu>{item.friction!r}</mu><mu2>{item.friction!r}</mu2>
          </ode></friction>
          <contact><ode>
            <kp>{STIFFNESS!r}</kp><kd>{DAMPING!r}</kd>
            <min_depth>{MIN_DEPTH!r}</min_depth><max_vel>{MAX_VEL!r}</max_vel>
          </ode></contact>
        </surface>
      </collision>
      <visual name="{visual}">
        {where}
        <material><ambient>{color}</ambient><diffuse>{color}</diffuse></material>
        <transparency>{1.0 - item.rgba[3]!r}</transparency>
      </visual>
"""


def check_world(file: Path) -> None:
    """Raise DescriptionError unless ``file`` is an SDF file that contains a world."""
    root = _root(file, "world")
    if root.tag != "sdf" or root.find("world") is None:
        raise DescriptionError(
            f"<{root.tag}> is not a world; write <sdf><world>…</world></sdf>",
            SourceLocation(file, 1),
        )


def check_model(file: Path) -> None:
    """Raise DescriptionError unless ``file`` is a URDF, or an SDF file with a model."""
    root = _root(file, "model")
    if root.tag != "robot" and (root.tag != "sdf" or root.find("model") is None):
        raise DescriptionError(
            f"<{root.tag}> is not a model; write <sdf><model>…</model></sdf>, "
            "or a URDF with <robot>",
            SourceLocation(file, 1),
        )


def unit_inertia(solid: Solid) -> BodyInertia:
    """Return the inertia of a homogeneous solid of 1 kg.

    Raises:
        ModelError: If a mesh of the solid cannot be read or encloses no volume.
    """
    match solid:
        case Box(size=(x, y, z)):
            return _centred(y * y + z * z, x * x + z * z, x * x + y * y, over=12.0)
        case Cylinder(radius=r, length=length):
            across = 3.0 * r * r + length * length
            return _centred(across, across, 6.0 * r * r, over=12.0)
        case Sphere(radius=r):
            return _centred(r * r, r * r, r * r, over=2.5)
        case Mesh(path=path, scale=scale):
            return _enclosed(_triangles(path) * np.asarray(scale), path)
        case Compound(parts=parts):
            units = [unit_inertia(geometry) for geometry, _ in parts]
            volumes = [volume(geometry) for geometry, _ in parts]
            return BodyInertia.total(
                [
                    _placed(unit, part / sum(volumes), pose)
                    for unit, part, (_, pose) in zip(units, volumes, parts, strict=True)
                ]
            )


def volume(geometry: Geometry) -> float:
    """Return the volume of a shape [m³]; raise ModelError if a mesh cannot be read."""
    match geometry:
        case Box(size=size):
            return math.prod(size)
        case Cylinder(radius=r, length=length):
            return math.pi * r * r * length
        case Sphere(radius=r):
            return 4.0 / 3.0 * math.pi * r**3
        case Mesh(path=path, scale=scale):
            triangles = _triangles(path) * np.asarray(scale)
            return abs(float(np.linalg.det(triangles).sum())) / 6.0


def check_mesh(path: Path) -> None:
    """Raise ModelError unless the file is a mesh.

    Gazebo would ignore an invalid file without an error.  In a COLLADA file, only the
    XML is checked, since malformed XML would crash gzserver.
    """
    if path.suffix.lower() != ".dae":
        _triangles(path)
        return
    try:
        ET.parse(path)
    except (OSError, ET.ParseError) as error:
        raise ModelError(f"cannot read the mesh {path}: {error}") from None


def _geometry(geometry: Geometry) -> str:
    match geometry:
        case Box(size=(x, y, z)):
            shape = f"<box><size>{x!r} {y!r} {z!r}</size></box>"
        case Cylinder(radius=r, length=length):
            size = f"<radius>{r!r}</radius><length>{length!r}</length>"
            shape = f"<cylinder>{size}</cylinder>"
        case Sphere(radius=r):
            shape = f"<sphere><radius>{r!r}</radius></sphere>"
        case Mesh(path=path, scale=(x, y, z)):
            scale = f"<scale>{x!r} {y!r} {z!r}</scale>"
            shape = f"<mesh><uri>{path.as_uri()}</uri>{scale}</mesh>"
    return f"<geometry>{shape}</geometry>"


def _inertial(item: SceneObject) -> str:
    if item.mass is None:
        return ""
    unit = unit_inertia(item.geometry)
    x, y, z = unit.center.tolist()
    moments = "".join(
        f"<i{row}{column}>{float(item.mass * unit.tensor[i, j])!r}</i{row}{column}>"
        for i, row in enumerate("xyz")
        for j, column in enumerate("xyz")
        if i <= j
    )
    return (
        f"<inertial><pose>{x!r} {y!r} {z!r} 0 0 0</pose><mass>{item.mass!r}</mass>"
        f"<inertia>{moments}</inertia></inertial>"
    )


def _root(file: Path, what: str) -> ET.Element:
    try:
        return ET.parse(file).getroot()
    except OSError as error:
        raise DescriptionError(
            f"cannot read the {what} {file}: {error.strerror}"
        ) from None
    except ET.ParseError as error:
        line = error.position[0]
        raise DescriptionError(
            f"not XML: {error}", SourceLocation(file, line)
        ) from None


def _centred(*moments: float, over: float) -> BodyInertia:
    return BodyInertia(1.0, np.zeros(3), np.diag(moments) / over)


def _placed(unit: BodyInertia, mass: float, pose: Pose) -> BodyInertia:
    """Return the inertia of a solid, scaled from 1 kg and moved to ``pose``."""
    frame = pose_matrix(pose)
    R = frame[:3, :3]
    center = R @ unit.center + frame[:3, 3]
    return BodyInertia(mass, center, mass * R @ unit.tensor @ R.T)


def _enclosed(triangles: Array, path: Path) -> BodyInertia:
    """Return the inertia of the solid enclosed by triangles, shape (n, 3, 3).

    The inertia is the signed sum over the tetrahedra between each triangle and the
    origin.  See F.  Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia
    tensor" (2004).
    """
    sixfold = np.linalg.det(triangles)  # six times the volumes
    volume = sixfold.sum() / 6.0
    extent = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    if not abs(volume) > 1e-9 * extent**3:
        raise ModelError(
            f"the mesh {path} encloses no volume, so it cannot have a mass; "
            "close its surface, or omit the mass"
        )
    sums = triangles.sum(axis=1)
    center = sixfold @ sums / 24.0 / volume
    second = np.einsum("n,nki,nkj->ij", sixfold, triangles, triangles)
    second += np.einsum("n,ni,nj->ij", sixfold, sums, sums)
    spread = second / 120.0 / volume - np.outer(center, center)
    return BodyInertia(1.0, center, np.trace(spread) * np.eye(3) - spread)


def _triangles(path: Path) -> Array:
    """Return the triangles of an STL or OBJ file, shape (n, 3, 3)."""
    read = {".stl": _read_stl, ".obj": _read_obj}.get(path.suffix.lower())
    if read is None:
        raise ModelError(
            f"cannot read the mesh {path}: use STL or OBJ; a static object may use DAE"
        )
    try:
        triangles = read(path.read_bytes())
    except (OSError, ValueError, IndexError, struct.error) as error:
        raise ModelError(f"cannot read the mesh {path}: {error}") from None
    if not len(triangles):
        raise ModelError(f"the mesh {path} has no triangles")
    return triangles


def _read_stl(data: bytes) -> Array:
    """Return the triangles in a binary or ASCII STL file.

    Binary files are recognized by their size.
    """
    # Sizes of name and count, and of normal, corners and two unused bytes [bytes].
    header, record = 84, 50
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
