"""The pad of a finger."""

from __future__ import annotations

from .model import Box, LinkShape, Vector
from .solid import Circle, Solid, plate

PITCH = 0.0045
"""From one rib to the next [m]."""
DEPTH = 0.0007
"""Of the grooves between the ribs [m]."""


def rubber_pad(size: Vector) -> LinkShape:
    """Return a ribbed pad [m] whose ribs reach the face of its collision box.

    The face at -y grips.
    """
    x, y, z = (side / 2 for side in size)
    edge = 0.0006
    corners: list[Circle] = [
        (at, sz * (z - edge), edge)
        for at in (y - edge, -y + DEPTH + edge)
        for sz in (-1, 1)
    ]
    back = plate(corners, x=(-x, x), segments=8)
    return LinkShape(
        visual={"rubber": (back, *_ribs(x, -y, z - edge))},
        collision=(Box(size=size),),
    )


def _ribs(half_width: float, face: float, half_height: float) -> list[Solid]:
    """Return ribs along x on the gripping ``face`` [m]."""
    count = int(2 * half_height / PITCH)
    top, radius = 0.28 * PITCH, 0.0003
    return [
        plate(
            [
                (face + radius, z - top + radius, radius),
                (face + radius, z + top - radius, radius),
                (face + DEPTH + radius, z - 1.5 * top, radius),
                (face + DEPTH + radius, z + 1.5 * top, radius),
            ],
            x=(-half_width + 0.0006, half_width - 0.0006),
            chamfer=0.0,
            segments=4,
        )
        for z in (PITCH * (k - (count - 1) / 2) for k in range(count))
    ]
