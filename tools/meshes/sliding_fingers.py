"""Fingers that slide towards each other on a round body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

from .model import Box, Cylinder, LinkShape, Vector
from .pad import rubber_pad
from .solid import Circle, block, plate, rounded, turned

RADIUS = 0.0375
"""Of the body [m]."""
CARRIAGE = (0.0010, 0.0370)
"""How far a carriage reaches outwards from the gripping face [m]."""
CARRIAGE_TOP = 0.0120
"""Above the body [m]."""
GAP = 0.0005
"""Between body and carriage [m]."""
FINGER = 0.0150
"""Thickness of a finger behind its pad [m]."""


@final
class SlidingFingers:
    """Where the fingers of a gripper are, and how long [m]."""

    def __init__(self, places: Mapping[str, Any]) -> None:
        """Take over the places in ``kinematics.yaml``."""
        self._height = places["finger"]["z"]
        self._pad_z = places["pad"]["z"]
        x, y, z = places["pad_size"]
        self._pad_size: Vector = (x, y, z)

    def links(self) -> dict[str, LinkShape]:
        """Return the shape of each link."""
        return {
            "base": self._base(),
            "finger": self._finger(),
            "pad": rubber_pad(self._pad_size),
        }

    def _base(self) -> LinkShape:
        """A coupling, a round body that gets flatter, and the rail on its top."""
        top = self._height
        body = [
            (RADIUS - 0.001, RADIUS - 0.001, RADIUS - 0.001, 0.0135),
            (RADIUS - 0.001, RADIUS, RADIUS - 0.001, 0.0300),
            (RADIUS - 0.004, RADIUS, 0.0220, 0.0550),
            (RADIUS - 0.006, RADIUS, 0.0120, top - 0.010),
            (RADIUS - 0.0075, RADIUS - 0.0015, 0.0110, top - 0.0075),
        ]
        rail: list[Circle] = [
            (side * (RADIUS - 0.0015), z, 0.0005)
            for side in (-1, 1)
            for z in (top - 0.0080, top - 0.0005)
        ]
        return LinkShape(
            visual={
                "black": (
                    turned(rounded(RADIUS, 0.0, 0.0115, above=0.0012)),
                    block(body),
                ),
                "metal": (
                    turned(rounded(RADIUS - 0.003, 0.010, 0.0145)),
                    plate(rail, x=(-0.017, 0.017)),
                ),
            },
            collision=(Cylinder(radius=RADIUS, length=top, xyz=(0.0, 0.0, top / 2)),),
        )

    def _finger(self) -> LinkShape:
        """A carriage on the rail, and the upright finger that carries the pad."""
        half_x, thickness, height = self._pad_size[0] / 2, *self._pad_size[1:]
        low, high = self._pad_z - height / 2, self._pad_z + height / 2
        near, far = CARRIAGE
        edge = 0.0015
        carriage: list[Circle] = [
            (y, z, edge)
            for y in (near + edge, far - edge)
            for z in (GAP + edge, CARRIAGE_TOP - edge)
        ]
        finger: list[Circle] = [
            (thickness + 0.0005, CARRIAGE_TOP - 0.002, 0.0005),
            (thickness + 0.0005, high - 0.0005, 0.0005),
            (thickness + FINGER * 0.6, high - 0.003, 0.0030),
            (thickness + FINGER - 0.003, low + 0.002, 0.0030),
            (thickness + FINGER, CARRIAGE_TOP - 0.003, 0.0020),
        ]
        back = thickness + 0.0005
        return LinkShape(
            visual={
                "grey": (plate(carriage, x=(-0.0155, 0.0155), chamfer=0.001),),
                "black": (plate(finger, x=(-half_x, half_x), chamfer=0.001),),
            },
            collision=(
                Box(
                    size=(0.031, far - near, CARRIAGE_TOP - GAP),
                    xyz=(0.0, (near + far) / 2, (GAP + CARRIAGE_TOP) / 2),
                ),
                Box(
                    size=(2 * half_x, FINGER, high - CARRIAGE_TOP),
                    xyz=(0.0, back + FINGER / 2, (CARRIAGE_TOP + high) / 2),
                ),
            ),
        )
