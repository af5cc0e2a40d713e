"""Coarser meshes for parts of the robot that are small in an image.

Without a graphics card, rendering time is about proportional to the number of
triangles, each of which is drawn three times: once into the shadow map and once for
each of the two lights.  Where a pixel is wider than the details of a mesh, a coarse
mesh replaces it.
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
"""Edge of the cubes in which a coarse mesh's corners are merged into one [m].  Coarse
meshes are used where a pixel is at least this wide."""
WORTH: Final = 0.85
"""Largest fraction of triangles that a coarse mesh may keep to be worth using."""
HIDDEN_GROUP: Final = 5
"""Group of the geoms that images do not show."""
_SUFFIX: Final = "/coarse"


class Shape(NamedTuple):
    """The surface of a mesh."""

    points: NDArray[np.float64]
    """Corners [m], shape (n, 3)."""
    faces: NDArray[np.int64]
    """Triangles, as indices of their corners, shape (m, 3)."""


def simplified(shape: Shape, cell: float) -> Shape:
    """Return a shape with the corners in each cube of edge ``cell`` merged into one.

    J. Rossignac, P. Borrel, Multi-resolution 3D approximations for rendering complex
    scenes (1993): no corner moves farther than the diagonal of a cell.
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
    """Add a hidden coarse geom for each visual mesh of a robot's ``spec``."""
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
    """Add a mesh's coarse version; return its name, or None if it saves too little."""
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
    """Chooses between the meshes of a compiled model and their coarse versions."""

    def __init__(self, model: Any) -> None:
        """Find fine and coarse meshes by their names."""
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
        """Show coarse meshes that are far enough from ``camera`` at ``frame``."""
        forward = [row[2] for row in frame.rotation]
        away = (data.geom_xpos[self._fine] - frame.position) @ forward - self._radii
        pixel = 2.0 * math.tan(camera.field_of_view / 2.0) / camera.height
        is_coarse = pixel * away >= CELL
        group = self._model.geom_group
        group[self._fine] = np.where(is_coarse, HIDDEN_GROUP, VISUAL_GROUP)
        group[self._coarse] = np.where(is_coarse, VISUAL_GROUP, HIDDEN_GROUP)
