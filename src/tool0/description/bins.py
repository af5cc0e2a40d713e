"""A bin: an open box that stands still, made of five boxes."""

from __future__ import annotations

from collections.abc import Sequence

from tool0.description.kinematics import to_transform
from tool0.description.model import Box, Pose, Vector3
from tool0.description.scene import (
    DEFAULT_FRICTION,
    RGBA,
    STILL_RGBA,
    SceneObject,
)
from tool0.errors import ConfigError

DEFAULT_WALL = 0.004
"""Thickness of floor and walls [m]: of a common plastic box."""


def bin_walls(
    name: str,
    *,
    size: Sequence[float],
    wall: float = DEFAULT_WALL,
    pose: Pose | None = None,
    friction: float = DEFAULT_FRICTION,
    rgba: RGBA = STILL_RGBA,
) -> tuple[SceneObject, ...]:
    """Return floor and walls of a bin that is open above.

    Args:
        name: They are called ``name.floor``, ``.front`` (+x), ``.back``, ``.left``
            (+y) and ``.right``.
        size: Outer edges x, y, z [m].
        wall: Thickness of floor and walls [m].
        pose: Of the centre of the outer box, in the robot's root.
        friction: Of each of the five.
        rgba: Of each of the five.

    Raises:
        ConfigError: If the walls leave no room inside, or a value cannot be.
    """
    x, y, z = size
    if not 0.0 < 2 * wall < min(x, y) or not wall < z:
        raise ConfigError(
            f"the walls of bin '{name}' must be above 0 m and leave room inside, "
            f"got wall {wall:g} for size {x:g}, {y:g}, {z:g}"
        )
    high, up = z - wall, wall / 2
    parts: dict[str, tuple[Vector3, Vector3]] = {
        "floor": ((x, y, wall), (0.0, 0.0, -high / 2)),
        "front": ((wall, y, high), ((x - wall) / 2, 0.0, up)),
        "back": ((wall, y, high), ((wall - x) / 2, 0.0, up)),
        "left": ((x - 2 * wall, wall, high), (0.0, (y - wall) / 2, up)),
        "right": ((x - 2 * wall, wall, high), (0.0, (wall - y) / 2, up)),
    }
    pose = pose or Pose()
    T_root_bin = to_transform(pose)
    return tuple(
        SceneObject(
            name=f"{name}.{part}",
            geometry=Box(size=edges),
            pose=Pose(xyz=T_root_bin.apply(centre), rpy=pose.rpy),
            friction=friction,
            rgba=rgba,
        )
        for part, (edges, centre) in parts.items()
    )
