"""The ground in images.

MuJoCo draws a plane as thousands of triangles, because light is computed at the corners
of triangles.  Without a graphics card, drawing such a plane takes longer than drawing a
robot.  The ground in this module has only a few hundred triangles, which are smallest
below the camera.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import mujoco
import numpy as np

from tool0.description.scene import GROUND

RADII: Final = (0.2, 0.45, 0.75, 1.1, 1.5, 2.0, 2.6, 3.4, 4.5, 6.0, 9.0, 1000.0)
"""Radii of the rings of triangles [m].  Beyond the second-to-last radius, color images
show only sky (``rendering.HAZE``).  Depth images are exact for triangles of any
size."""
SECTORS: Final = 20
"""Number of triangles around the center."""
RGBA: Final = (0.85, 0.86, 0.88, 1.0)


def add_ground(spec: Any, height: float) -> None:
    """Add the ground to ``spec`` at ``height`` [m] in the robot's root."""
    angles = np.linspace(0.0, 2.0 * np.pi, SECTORS, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(SECTORS)], axis=1)
    vertices = np.vstack([np.zeros((1, 3)), *(radius * ring for radius in RADII)])
    spec.add_mesh(
        name=GROUND,
        uservert=vertices.ravel(),
        userface=np.array(_faces()).ravel(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    spec.worldbody.add_geom(
        name=GROUND,
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=GROUND,
        pos=[0.0, 0.0, height],
        contype=0,
        conaffinity=0,
        mass=0.0,
        rgba=RGBA,
    )


def put_ground_below(model: Any, data: Any, camera: Sequence[float]) -> None:
    """Move the ground's center below the position of a ``camera`` in the root [m].

    ``mj_kinematics`` moves the ground back.
    """
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, GROUND)
    if number >= 0:
        data.geom_xpos[number, :2] = camera[:2]


def _faces() -> list[tuple[int, int, int]]:
    """Return the triangles as corner indices, counterclockwise seen from above."""

    def corner(ring: int, sector: int) -> int:
        return 1 + ring * SECTORS + sector % SECTORS

    faces = [(0, corner(0, k), corner(0, k + 1)) for k in range(SECTORS)]
    for ring in range(len(RADII) - 1):
        for k in range(SECTORS):
            near, far = corner(ring, k), corner(ring + 1, k)
            next_near, next_far = corner(ring, k + 1), corner(ring + 1, k + 1)
            faces += [(near, far, next_far), (near, next_far, next_near)]
    return faces
