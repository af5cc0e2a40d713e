"""Closed triangle meshes, and the three ways of drawing one.

A solid is a loft: a stack of closed loops with the same number of points, joined by
quads and closed by a fan at either end. A loop whose points coincide is a point.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
Profile: TypeAlias = Sequence[tuple[float, float]]
"""Points (radius, height) [m] of a turned part, from its lower to its upper face."""
Circle: TypeAlias = tuple[float, float, float]
"""Centre y, centre z and radius [m], in a gripper's plane of motion."""

GRID = 1e-6
"""Vertices lie on this grid [m], so that every machine writes the same bytes."""
ROUNDED = 0.0012
"""Bevels of plates from this size on are rounded [m]."""
AXES = {
    "+x": ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    "-x": ((0, 0, -1), (-1, 0, 0), (0, 1, 0)),
    "+y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "+z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
}
"""Rotation, by rows, that turns +z to the named axis."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solid:
    """A closed surface whose triangles turn anticlockwise seen from outside."""

    vertices: Array
    """Positions [m], shape (n, 3)."""
    triangles: npt.NDArray[np.int64]
    """Rows of ``vertices``, shape (m, 3)."""

    @property
    def corners(self) -> Array:
        """The triangles' corners [m], shape (m, 3, 3)."""
        return np.asarray(self.vertices[self.triangles])

    @property
    def volume(self) -> float:
        """Enclosed volume [m³]; positive if the normals point outwards."""
        a, b, c = self.corners.transpose(1, 0, 2)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def turned(
    profile: Profile,
    *,
    axis: str = "+z",
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
    segments: int = 32,
) -> Solid:
    """Return the solid that a profile sweeps around ``axis`` through ``at`` [m]."""
    loops = [
        [(r * math.cos(t), r * math.sin(t), z) for t in _angles(segments)]
        for r, z in profile
    ]
    rotation = np.array(AXES[axis], dtype=np.float64)
    return loft(np.array(loops) @ rotation.T + np.array(at))


def plate(
    circles: Sequence[Circle],
    *,
    x: tuple[float, float],
    chamfer: float = 0.0005,
    segments: int = 14,
) -> Solid:
    """Return the hull of circles in the y-z plane, as thick as ``x`` [m] says.

    Its edges are bevelled, and rounded if the bevel is large enough to be seen.
    """
    low, high = x
    steps = 2 if chamfer >= ROUNDED else 1
    edge = [
        (chamfer * (1 - math.sin(t)), chamfer * (1 - math.cos(t)))
        for t in (math.pi / 2 * step / steps for step in range(steps + 1))
    ]
    loops = [(_hull(circles, inset, segments), depth) for inset, depth in edge]
    stack = [(loop, low + depth) for loop, depth in loops]
    stack += [(loop, high - depth) for loop, depth in reversed(loops)]
    return loft(np.array([[(at, y, z) for y, z in loop] for loop, at in stack]))


def block(
    sections: Sequence[tuple[float, float, float, float]], *, segments: int = 32
) -> Solid:
    """Return a stack of rounded rectangles: (half x, half y, corner radius, z) [m]."""
    loops = []
    for half_x, half_y, radius, z in sections:
        corner_x, corner_y = half_x - radius, half_y - radius
        corners = [
            (sx * corner_x, sy * corner_y, radius) for sx in (-1, 1) for sy in (-1, 1)
        ]
        loops.append([(x, y, z) for x, y in _hull(corners, 0.0, segments)])
    return loft(np.array(loops))


def loft(loops: Array) -> Solid:
    """Return the closed solid through ``loops`` [m], shape (n_loops, n_points, 3)."""
    n_loops, n, _ = loops.shape
    centres = loops[[0, -1]].mean(axis=1)
    vertices = np.round(np.vstack([loops.reshape(-1, 3), centres]) / GRID) * GRID + 0.0
    here = np.arange(n)
    there = (here + 1) % n
    parts = []
    for row in range(n_loops - 1):
        a, b = row * n + here, row * n + there
        parts += [np.column_stack([a, b, b + n]), np.column_stack([a, b + n, a + n])]
    bottom, top = n_loops * n, n_loops * n + 1
    last = (n_loops - 1) * n
    parts.append(np.column_stack([np.full(n, bottom), there, here]))
    parts.append(np.column_stack([np.full(n, top), last + here, last + there]))
    solid = Solid(vertices=vertices, triangles=_useful(vertices, np.vstack(parts)))
    if solid.volume > 0:
        return solid
    return Solid(vertices=solid.vertices, triangles=solid.triangles[:, ::-1])


def rounded(
    radius: float, low: float, high: float, *, below: float = 0.0, above: float = 0.0
) -> list[tuple[float, float]]:
    """Return the profile of a cylinder, its edges rounded by radii [m]."""
    profile = [(radius, low)]
    if below:
        profile = [
            (radius - below * (1 - math.sin(t)), low + below * (1 - math.cos(t)))
            for t in _quarter(below)
        ]
    if not above:
        return [*profile, (radius, high)]
    return profile + [
        (radius - above * (1 - math.cos(t)), high - above * (1 - math.sin(t)))
        for t in _quarter(above)
    ]


def _quarter(radius: float) -> list[float]:
    """Return the angles of a quarter turn: a small rounding is but a chamfer."""
    steps = 3 if radius > 0.003 else 1
    return [math.pi / 2 * step / steps for step in range(steps + 1)]


def _angles(segments: int) -> list[float]:
    return [2 * math.pi * step / segments for step in range(segments)]


def _hull(
    circles: Sequence[Circle], inset: float, segments: int
) -> list[tuple[float, float]]:
    """Return the outline of the circles' convex hull, a point per direction."""
    outline = []
    for t in _angles(segments):
        u, v = math.cos(t + 1e-3), math.sin(t + 1e-3)  # no ties between circles
        y, z, radius = max(circles, key=lambda c: c[0] * u + c[1] * v + c[2])
        outline.append(
            (y + (radius - inset) * math.cos(t), z + (radius - inset) * math.sin(t))
        )
    return outline


def _useful(vertices: Array, triangles: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Merge equal vertices and drop the triangles that this collapses."""
    _, first, inverse = np.unique(
        vertices, axis=0, return_index=True, return_inverse=True
    )
    merged = first[inverse.reshape(-1)][triangles]
    a, b, c = merged.T
    return np.asarray(merged[(a != b) & (b != c) & (c != a)])
