"""The pad of a finger."""

from __future__ import annotations

from .model import Box, LinkShape, Vector
from .solid import Circle, plate


def rubber_pad(size: Vector) -> LinkShape:
    """Return a pad [m]; its collision box is what a grasped object touches."""
    x, y, z = (side / 2 for side in size)
    edge = 0.0006
    corners: list[Circle] = [
        (sy * (y - edge), sz * (z - edge), edge) for sy in (-1, 1) for sz in (-1, 1)
    ]
    return LinkShape(
        visual={"rubber": (plate(corners, x=(-x, x), segments=8),)},
        collision=(Box(size=size),),
    )
