"""Coarse meshes for parts of the robot that are small in an image.

Without a graphics card, the rendering time is approximately proportional to the number
of triangles.  Each triangle is drawn three times: once into the shadow map and once for
each of the two lights.  A mesh is replaced by a coarse mesh where the details of the
mesh are smaller than a pixel.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple, final

import mujoco
import numpy as np
from numpy.typing import NDArray

from tool0.description.camera import Camera
from tool0.description.transform import Transform
from tool0.engines.mujoco.model import VISUAL_GROUP, compile_spec

CELL: Final = 0.006
"""Edge of the cubes in which the corners of a mesh are merged into one corner [m].  A
coarse mesh is used where one pixel spans at least this length at the mesh."""
WORTH: Final = 0.85
"""Largest number of triangles of a coarse mesh, as a fraction of that of the original
mesh, for which the coarse mesh is used."""
HIDDEN_GROUP: Final = 5
"""Group of the geoms that are not visible in images."""
_SUFFIX: Final = "/coarse"


class Shape(NamedTuple):
    """The surface of a mesh."""

    points: NDArray[np.float64]
    """Corners of the triangles [m], shape (n, 3)."""
    faces: NDArray[np.int64]
    """Triangles, as the indices of their corners, shape (m, 3)."""


def simplified(shape: Shape, cell: float) -> Shape:
    """Return a shape in which the corners in each cube of edge ``cell`` are merged.

    No corner moves farther than the diagonal of a cube.  See J.  Rossignac, P.  Borrel,
    Multi-resolution 3D approximations for rendering complex scenes (1993).
    """
    cells = np.floor(shape.points / cell).astype(np.int64)
    _, merged = np.unique(cells, axis=0, return_inverse=True)
    merged = merged.ravel()
    counts = np.bincount(merged)
    sums = [np.bincount(merged, axis) for axis in shape.points.T]
    faces = merged[shape.faces]
    first, second, third = faces.T
    is_left = (first != second) & (second != third) & (third != first)
    return Shape(np.stack(sums, axis=1) / counts[:, None], faces[is_left])


def add_coarse(spec: Any) -> None:
    """Add a hidden geom with a coarse mesh for each visual mesh in ``spec``."""
    model = compile_spec(spec.copy())
    names: dict[int, str | None] = {}
    for number in np.flatnonzero(model.geom_group == VISUAL_GROUP).tolist():
        geom = model.geom(number)
        if geom.type[0] != mujoco.mjtGeom.mjGEOM_MESH:
            continue
        mesh = int(geom.dataid[0])
        if mesh not in names:
            names[mesh] = _add_mesh(spec, model, mesh)
        if names[mesh] is None:
            continue
        body = int(geom.bodyid[0])
        handle = spec.body(model.body(body).name) if body else spec.worldbody
        handle.add_geom(
            name=geom.name + _SUFFIX,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=names[mesh],
            pos=geom.pos,
            quat=geom.quat,
            rgba=geom.rgba,
            group=HIDDEN_GROUP,
            contype=0,
            conaffinity=0,
            mass=0.0,
        )


def _add_mesh(spec: Any, model: Any, number: int) -> str | None:
    """Add a coarse version of a mesh, and return its name.

    If the coarse mesh has too many triangles, nothing is added and None is returned.
    """
    first, n = int(model.mesh_vertadr[number]), int(model.mesh_vertnum[number])
    points = model.mesh_vert[first : first + n].astype(float)
    first, n = int(model.mesh_faceadr[number]), int(model.mesh_facenum[number])
    faces = model.mesh_face[first : first + n].astype(np.int64)
    coarse = simplified(Shape(points, faces), CELL)
    if len(coarse.faces) > WORTH * n or len(coarse.faces) < 4:
        return None
    name = f"{model.mesh(number).name}{_SUFFIX}"
    spec.add_mesh(
        name=name,
        uservert=coarse.points.ravel(),
        userface=coarse.faces.ravel(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    return name


@final
class Detail:
    """Selection between the meshes of a compiled model and the coarse meshes."""

    def __init__(self, model: Any) -> None:
        """Find the fine and the coarse meshes by their names."""
        names = {model.geom(k).name: k for k in range(model.ngeom)}
        pairs = [
            (names[name.removesuffix(_SUFFIX)], k)
            for name, k in names.items()
            if name.endswith(_SUFFIX) and model.geom_group[k] == HIDDEN_GROUP
        ]
        self._model = model
        self._fine, self._coarse = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        self._radii = model.geom_rbound[self._fine]

    def choose(self, data: Any, camera: Camera, frame: Transform) -> None:
        """Replace meshes far from ``camera``, at pose ``frame``, by coarse ones."""
        forward = [row[2] for row in frame.rotation]
        away = (data.geom_xpos[self._fine] - frame.position) @ forward - self._radii
        pixel = 2.0 * math.tan(camera.field_of_view / 2.0) / camera.height
        is_coarse = pixel * away >= CELL
        group = self._model.geom_group
        group[self._fine] = np.where(is_coarse, HIDDEN_GROUP, VISUAL_GROUP)
        group[self._coarse] = np.where(is_coarse, VISUAL_GROUP, HIDDEN_GROUP)
