"""Fingers that swing, each on a parallelogram, and their body.

All joints turn about x, so every part is drawn in the y-z plane and given a thickness.
Bars that meet at a pin lie in different layers of x, as forks and tongues do.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, final

from .model import Box, Cylinder, LinkShape, Vector
from .pad import rubber_pad
from .solid import Circle, Solid, block, plate, rounded, turned

TONGUE = 0.0062
"""Half the thickness of a bar held in a fork [m]."""
FORK = (0.0066, 0.0110)
"""Inner and outer face of a fork's prong, from the plane of symmetry [m]."""
PRONG = (0.0072, 0.0118)
"""The same for the outer finger, which is the widest part of a finger [m]."""
CHEEK = (0.0122, 0.0185)
"""Inner and outer face of the body's cheeks [m]."""


@final
class SwingingFingers:
    """The joint origins (y, z) and lengths of a gripper [m]."""

    def __init__(self, places: Mapping[str, Any]) -> None:
        """Take over the places in ``kinematics.yaml``."""

        def at(key: str) -> tuple[float, float]:
            return places[key]["y"], places[key]["z"]

        self.outer_pivot, self.inner_pivot = at("outer_knuckle"), at("inner_knuckle")
        self.outer_knuckle, self.outer_finger = at("outer_finger"), at("inner_finger")
        self.pad = at("inner_finger_pad")
        x, y, z = places["pad_size"]
        self.pad_size: Vector = (x, y, z)
        # This vector closes the parallelogram.
        self.inner_knuckle = (
            self.outer_knuckle[0] + self.outer_finger[0],
            self.outer_knuckle[1] + self.outer_finger[1],
        )
        # From the inner finger's own pivot to its pin on the inner knuckle.
        self.inner_pin = (
            self.inner_pivot[0] - self.outer_pivot[0],
            self.inner_pivot[1] - self.outer_pivot[1],
        )

    def links(self) -> dict[str, LinkShape]:
        """Return the shape of each link."""
        return {
            "base": self._base(),
            "outer_knuckle": self._outer_knuckle(),
            "outer_finger": self._outer_finger(),
            "inner_knuckle": self._inner_knuckle(),
            "inner_finger": self._inner_finger(),
            "inner_finger_pad": rubber_pad(self.pad_size),
        }

    def _base(self) -> LinkShape:
        """A coupling, a body from round to oblong, and cheeks that hold four pins."""
        coupling = [*rounded(0.0375, 0.0, 0.0115, above=0.0012)]
        body = [
            (0.0365, 0.0365, 0.0365, 0.0135),
            (0.0365, 0.0370, 0.0360, 0.0200),
            (0.0320, 0.0375, 0.0230, 0.0330),
            (0.0255, 0.0375, 0.0120, 0.0415),
            (0.0230, 0.0360, 0.0105, 0.0447),
            (0.0195, 0.0340, 0.0080, 0.0455),
        ]
        cheek: list[Circle] = [
            (side * y, z, radius)
            for side in (-1, 1)
            for y, z, radius in (
                (0.0260, 0.0380, 0.0080),
                (*self.outer_pivot, 0.0085),
                (0.0085, 0.0800, 0.0070),
            )
        ]
        pivots = [
            (side * y, z)
            for side in (-1, 1)
            for y, z in (self.outer_pivot, self.inner_pivot)
        ]
        pins = [_pin(pivot, CHEEK[1] + 0.0008, 0.0042) for pivot in pivots]
        return LinkShape(
            visual={
                "black": (
                    turned(coupling),
                    block(body),
                    *_both(cheek, CHEEK, chamfer=0.0020),
                    plate(
                        [(0.0, 0.045, 0.0035), (0.0, 0.0815, 0.0035)],
                        x=(-CHEEK[0], CHEEK[0]),
                    ),
                ),
                "metal": (turned(rounded(0.0345, 0.010, 0.0145)), *pins),
            },
            collision=(
                Cylinder(radius=0.0375, length=0.042, xyz=(0.0, 0.0, 0.021)),
                Box(size=(0.036, 0.008, 0.042), xyz=(0.0, 0.0, 0.063)),
            ),
        )

    def _outer_knuckle(self) -> LinkShape:
        """The driven crank, between the body's cheeks."""
        return LinkShape(
            visual={
                "black": (
                    plate(
                        [(0.0, 0.0, 0.0085), (*self.outer_knuckle, 0.0075)],
                        x=(-FORK[1], FORK[1]),
                        chamfer=0.001,
                    ),
                ),
            },
            collision=(_bar(self.outer_knuckle, 0.008, 0.0, 0.012, 2 * FORK[1]),),
        )

    def _outer_finger(self) -> LinkShape:
        """The coupler: it is fixed to the crank and forks around the inner finger."""
        foot, tip = (0.0, 0.0, 0.0082), (*self.outer_finger, 0.0061)
        waist = (self.outer_finger[0] * 0.45, self.outer_finger[1] * 0.45, 0.0062)
        return LinkShape(
            visual={
                "grey": (
                    plate(
                        [foot, waist],
                        x=(-PRONG[1] + 0.001, PRONG[1] - 0.001),
                        segments=12,
                    ),
                    *_both([foot, tip], PRONG, chamfer=0.0014),
                ),
                "metal": (
                    _pin((0.0, 0.0), PRONG[1] + 0.0006, 0.0036),
                    _pin(self.outer_finger, PRONG[1] + 0.0006, 0.0034),
                ),
            },
            collision=(_bar(self.outer_finger, 0.0, 0.0, 0.0122, 2 * PRONG[1]),),
        )

    def _inner_knuckle(self) -> LinkShape:
        """The follower of the parallelogram, a tongue at its upper end."""
        y, z = self.inner_knuckle
        shank = (0.62 * y, 0.62 * z, 0.0060)
        return LinkShape(
            visual={
                "grey": (
                    plate([(0.0, 0.0, 0.0072), shank], x=(-FORK[1], FORK[1])),
                    plate([shank, (y, z, 0.0062)], x=(-TONGUE, TONGUE)),
                ),
            },
            collision=(_bar(self.inner_knuckle, 0.008, -0.008, 0.011, 2 * FORK[1]),),
        )

    def _inner_finger(self) -> LinkShape:
        """The fingertip: a fork below, on two pins, and a back for the pad above."""
        pin = (*self.inner_pin, 0.0066)
        pad_back = self.pad[0] + self.pad_size[1] / 2
        low, high = (
            self.pad[1] - self.pad_size[2] / 2,
            self.pad[1] + self.pad_size[2] / 2,
        )
        tongue: list[Circle] = [(0.0, 0.0, 0.0058), (pad_back + 0.0085, low, 0.0050)]
        back: list[Circle] = [
            (pad_back + 0.0012, low + 0.0003, 0.0012),
            (pad_back + 0.0012, high - 0.0012, 0.0012),
            (pad_back + 0.0090, low + 0.0030, 0.0045),
            (pad_back + 0.0040, high - 0.0030, 0.0030),
        ]
        prong: list[Circle] = [pin, (pad_back + 0.0035, low + 0.0040, 0.0033)]
        return LinkShape(
            visual={
                "black": (
                    plate(tongue, x=(-TONGUE, TONGUE), segments=12),
                    plate(back, x=(-FORK[1], FORK[1]), chamfer=0.0008),
                    *_both(prong, (FORK[0], FORK[1] - 0.0004)),
                ),
                "metal": (_pin(self.inner_pin, FORK[1] + 0.0008, 0.0034),),
            },
            collision=(
                Box(
                    size=(2 * FORK[1], 0.0115, high - low - 0.001),
                    xyz=(0.0, pad_back + 0.0005 + 0.0115 / 2, self.pad[1]),
                ),
            ),
        )


def _both(
    circles: list[Circle], layer: tuple[float, float], chamfer: float = 0.0005
) -> tuple[Solid, Solid]:
    """Return a plate in a layer of x, and its mirror image."""
    low, high = layer
    return (
        plate(circles, x=(low, high), chamfer=chamfer),
        plate(circles, x=(-high, -low), chamfer=chamfer),
    )


def _pin(at: tuple[float, float], half_length: float, radius: float) -> Solid:
    profile = rounded(radius, -half_length, half_length)
    return turned(profile, axis="+x", at=(0.0, *at), segments=12)


def _bar(
    end: tuple[float, float], start: float, beyond: float, width: float, depth: float
) -> Box:
    """Return a box along the way to ``end``, from ``start`` to ``beyond`` it [m].

    A box that ends before its pin leaves room for the link it meets there: MuJoCo
    lets only parent and child overlap, and the loop's last pin is not in the tree.
    """
    length = math.hypot(*end)
    middle = (start + length + beyond) / 2 / length
    xyz: Vector = (0.0, middle * end[0], middle * end[1])
    return Box(
        size=(depth, width, length + beyond - start),
        xyz=xyz,
        rpy=(-math.atan2(end[0], end[1]), 0.0, 0.0),
    )
