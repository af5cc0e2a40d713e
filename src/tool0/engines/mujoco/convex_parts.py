"""Decomposition of a mesh into parts that are nearly convex.

MuJoCo uses a mesh's convex hull for collisions.  The hull of a forearm with a joint at
each end also fills the space between the joints, in which the wrist moves.
"""

from __future__ import annotations

import functools
from typing import Final

import mujoco
import numpy as np
import numpy.typing as npt

from tool0.description.shapes import Mesh
from tool0.errors import ModelError

Points = npt.NDArray[np.float64]

MAX_PARTS: Final = 8
"""Largest number of parts of one mesh."""
MIN_GAIN: Final = 0.06
"""Smallest reduction in the total volume of the boxes that justifies a cut, as a
fraction of the volume of the mesh's bounding box."""
_CUTS: Final = 11
"""Number of planes, perpendicular to each axis, at which a mesh can be cut."""
_THIN: Final = 1e-4
"""Smallest thickness of a part [m], since MuJoCo requires hulls with a volume."""


def convex_parts(mesh: Mesh) -> tuple[Points, ...]:
    """Return the points of each part of ``mesh``, shape (n, 3) [m].

    A mesh that is nearly convex remains one part.  Other meshes are cut perpendicular
    to their axes, at the positions that minimize the volume of the parts' bounding
    boxes.

    Raises:
        ModelError: If MuJoCo cannot read the mesh.
    """
    written = mesh.path.stat()
    return _parts(str(mesh.path), mesh.scale, written.st_mtime_ns, written.st_size)


@functools.lru_cache(maxsize=64)
def _parts(
    path: str, scale: tuple[float, float, float], _written: int, _size: int
) -> tuple[Points, ...]:
    whole = _triangles(path, scale)
    price = MIN_GAIN * _box_volume(whole)
    waiting = [whole]
    done: list[Points] = []
    while waiting:
        part = waiting.pop()
        segments = _segments(part, price)
        if 1 < len(segments) <= MAX_PARTS - len(waiting) - len(done):
            waiting += segments
        else:
            done.append(part)
    return tuple(np.unique(part.reshape(-1, 3), axis=0) for part in done)


def _triangles(path: str, scale: tuple[float, float, float]) -> Points:
    """Return the triangles of a mesh file in the file's frame, shape (n, 3, 3) [m]."""
    spec = mujoco.MjSpec()
    spec.add_mesh(name="mesh", file=path, scale=scale)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
    try:
        model = spec.compile()
    except ValueError as error:
        raise ModelError(f"MuJoCo rejects the mesh {path}: {error}") from error
    # MuJoCo moves the origins of meshes to their centers of mass.
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.mesh_quat[0])
    points = model.mesh_vert @ rotation.reshape(3, 3).T + model.mesh_pos[0]
    triangles: Points = points[model.mesh_face].astype(float)
    return triangles


def _segments(triangles: Points, price: float) -> list[Points]:
    """Return the segments along one axis that minimize the volume of their boxes.

    A ``price`` [m³] is added for each segment, in order to avoid unnecessary segments.
    """
    least, best = _box_volume(triangles), [triangles]
    for axis in range(3):
        slabs = _slabs(triangles, axis)
        boxes = np.array([_box(slab) for slab in slabs])
        # For each n: the smallest cost of segments of the first n slabs, and the first
        # slab of the last segment.
        costs, firsts = [0.0], [0]
        for n in range(1, len(slabs) + 1):
            lower = np.minimum.accumulate(boxes[n - 1 :: -1, 0][:n])
            upper = np.maximum.accumulate(boxes[n - 1 :: -1, 1][:n])
            # Box volumes of the slabs k to n.
            volumes = np.prod(upper - lower, axis=1)[::-1]
            totals = np.array(costs) + volumes + price
            firsts.append(int(np.argmin(totals)))
            costs.append(float(totals[firsts[-1]]))
        if costs[-1] - price < least:
            least, best, end = costs[-1] - price, [], len(slabs)
            while end > 0:
                best.append(np.concatenate(slabs[firsts[end] : end]))
                end = firsts[end]
    return best


def _slabs(triangles: Points, axis: int) -> list[Points]:
    """Return the parts between planes perpendicular to an axis.

    A part that is too thin is merged with the next part.
    """
    lower, upper = _box(triangles)
    slabs, rest = [], triangles
    for place in np.linspace(lower[axis], upper[axis], _CUTS + 2)[1:-1]:
        below, above = _side(rest, axis, place, 1), _side(rest, axis, place, -1)
        if _is_solid(below) and _is_solid(above):
            slabs.append(below)
            rest = above
    return [*slabs, rest]


def _side(triangles: Points, axis: int, place: float, sign: int) -> Points:
    """Return the triangles on one side of a plane, below it if ``sign`` is 1."""
    depths = sign * (place - triangles[:, :, axis])
    inside = depths >= 0.0
    counts = inside.sum(axis=1)
    a, b, c, p, q = _cut(triangles, depths, inside, counts == 1, apex_inside=True)
    tips = np.stack((a, p, q), axis=1)
    a, b, c, p, q = _cut(triangles, depths, inside, counts == 2, apex_inside=False)
    stumps = np.concatenate((np.stack((p, b, c), axis=1), np.stack((p, c, q), axis=1)))
    return np.concatenate((triangles[counts == 3], tips, stumps))


def _cut(
    triangles: Points,
    depths: Points,
    inside: npt.NDArray[np.bool_],
    chosen: npt.NDArray[np.bool_],
    *,
    apex_inside: bool,
) -> tuple[Points, Points, Points, Points, Points]:
    """Return the corners of triangles and the two points of each cut.

    The first corner of each triangle is the single corner on its side of the plane.
    """
    lone = np.argmax(inside[chosen] == apex_inside, axis=1)
    order = (lone[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(triangles[chosen], order[:, :, None], axis=1)
    depth = np.take_along_axis(depths[chosen], order, axis=1)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    to_b = depth[:, :1] / (depth[:, :1] - depth[:, 1:2])
    to_c = depth[:, :1] / (depth[:, :1] - depth[:, 2:3])
    return a, b, c, a + to_b * (b - a), a + to_c * (c - a)


def _is_solid(triangles: Points) -> bool:
    if len(triangles) < 4:
        return False
    lower, upper = _box(triangles)
    return bool(np.all(upper - lower > _THIN))


def _box_volume(triangles: Points) -> float:
    lower, upper = _box(triangles)
    return float(np.prod(upper - lower))


def _box(triangles: Points) -> tuple[Points, Points]:
    """Return the smallest and the largest corner of the bounding box [m]."""
    points = triangles.reshape(-1, 3)
    return points.min(axis=0), points.max(axis=0)
