"""The robot as MuJoCo's renderer can have it: without the meshes that it cannot read.

Physics needs no visual mesh; so a robot with COLLADA files runs, and should be seen.
"""

from __future__ import annotations

import logging
from dataclasses import replace

from tool0.description.model import Link, RobotModel, Visual
from tool0.description.shapes import Mesh
from tool0.engines.mujoco.model import MESH_SUFFIXES

logger = logging.getLogger(__name__)

RGBA = (0.6, 0.62, 0.65, 1.0)
"""Of shapes that stand in for a mesh."""


def drawable(model: RobotModel) -> RobotModel:
    """Return the robot; collision shapes stand in for meshes that cannot be read."""
    unread = sorted(
        {
            visual.geometry.path.name
            for link in model.links
            for visual in link.visuals
            if isinstance(visual.geometry, Mesh) and not _is_readable(visual)
        }
    )
    if not unread:
        return model
    logger.warning(
        "cameras show collision shapes instead of %s, which MuJoCo cannot read; "
        "convert them to STL or OBJ",
        ", ".join(unread),
    )
    return replace(model, links=tuple(map(_drawable, model.links)))


def _drawable(link: Link) -> Link:
    if all(map(_is_readable, link.visuals)):
        return link
    stand_ins = (
        Visual(geometry=item.geometry, origin=item.origin, rgba=RGBA)
        for item in link.collisions
    )
    kept = tuple(visual for visual in link.visuals if _is_readable(visual))
    return replace(link, visuals=kept or tuple(stand_ins))


def _is_readable(visual: Visual) -> bool:
    geometry = visual.geometry
    if not isinstance(geometry, Mesh):
        return True
    return geometry.path.suffix.lower() in MESH_SUFFIXES
