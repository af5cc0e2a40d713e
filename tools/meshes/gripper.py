"""A Robotiq 2F-85: a dark tapered body and two fingers, each a parallelogram.

All joints turn about x, so every part is drawn in the y-z plane and given a thickness.
The left finger is the right one turned by pi about z, so that one mesh serves both.
Bars that meet at a pin lie in different layers of x, as forks and tongues do.
"""

from __future__ import annotations

import math

from .model import Box, Cylinder, LinkShape, ModelShape, Vector
from .solid import Circle, Solid, block, plate, rounded, turned

MATERIALS = {
    "black": (0.16, 0.16, 0.17, 1.0),
    "grey": (0.42, 0.43, 0.45, 1.0),
    "metal": (0.70, 0.71, 0.72, 1.0),
    "rubber": (0.24, 0.24, 0.25, 1.0),
}

# Joint origins (y, z) [m]: robotiq_arg2f_85_macro.xacro of
# https://github.com/jr-robotics/robotiq at 3aab694. The last vector closes the
# parallelogram: outer knuckle + outer finger = inner knuckle.
OUTER_PIVOT = (0.0306011, 0.054904)
INNER_PIVOT = (0.0127, 0.06142)
OUTER_KNUCKLE = (0.0315, -0.0041)
OUTER_FINGER = (0.0061, 0.0471)
INNER_KNUCKLE = (
    OUTER_KNUCKLE[0] + OUTER_FINGER[0],
    OUTER_KNUCKLE[1] + OUTER_FINGER[1],
)
PAD = (-0.0220203446692936, 0.03242)
PAD_SIZE = (0.022, 0.00635, 0.0375)
# From the inner finger's own pivot to its pin on the inner knuckle.
INNER_PIN = (INNER_PIVOT[0] - OUTER_PIVOT[0], INNER_PIVOT[1] - OUTER_PIVOT[1])

TONGUE = 0.0062
"""Half the thickness of a bar held in a fork [m]."""
FORK = (0.0066, 0.0110)
"""Inner and outer face of a fork's prong, from the plane of symmetry [m]."""
PRONG = (0.0072, 0.0118)
"""The same for the outer finger, which is the widest part of a finger [m]."""
CHEEK = (0.0122, 0.0185)
"""Inner and outer face of the body's cheeks [m]."""


def gripper_shape() -> ModelShape:
    """Return the shapes of the gripper's links, one for both fingers."""
    return ModelShape(
        kind="grippers",
        name="2f85",
        materials=MATERIALS,
        links={
            "base": _base(),
            "outer_knuckle": _outer_knuckle(),
            "outer_finger": _outer_finger(),
            "inner_knuckle": _inner_knuckle(),
            "inner_finger": _inner_finger(),
            "inner_finger_pad": _inner_finger_pad(),
        },
    )


def _base() -> LinkShape:
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
            (*OUTER_PIVOT, 0.0085),
            (0.0085, 0.0800, 0.0070),
        )
    ]
    pivots = [(side * y, z) for side in (-1, 1) for y, z in (OUTER_PIVOT, INNER_PIVOT)]
    pins = [_pin(pivot, CHEEK[1] + 0.0008, 0.0042) for pivot in pivots]
    return LinkShape(
        visual={
            "black": (
                turned(coupling),
                block(body),
                *_both(cheek, CHEEK, chamfer=0.0015),
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


def _outer_knuckle() -> LinkShape:
    """The driven crank, between the body's cheeks."""
    return LinkShape(
        visual={
            "grey": (
                plate(
                    [(0.0, 0.0, 0.0085), (*OUTER_KNUCKLE, 0.0075)],
                    x=(-FORK[1], FORK[1]),
                    chamfer=0.001,
                ),
            ),
        },
        collision=(_bar(OUTER_KNUCKLE, 0.008, 0.0, 0.012, 2 * FORK[1]),),
    )


def _outer_finger() -> LinkShape:
    """The coupler: it is fixed to the crank and forks around the inner finger."""
    foot, tip = (0.0, 0.0, 0.0082), (*OUTER_FINGER, 0.0061)
    waist = (OUTER_FINGER[0] * 0.45, OUTER_FINGER[1] * 0.45, 0.0062)
    return LinkShape(
        visual={
            "black": (
                plate([foot, waist], x=(-PRONG[1] + 0.001, PRONG[1] - 0.001)),
                *_both([foot, tip], PRONG, chamfer=0.001),
            ),
            "metal": (
                _pin((0.0, 0.0), PRONG[1] + 0.0006, 0.0036),
                _pin(OUTER_FINGER, PRONG[1] + 0.0006, 0.0034),
            ),
        },
        collision=(_bar(OUTER_FINGER, 0.0, 0.0, 0.0122, 2 * PRONG[1]),),
    )


def _inner_knuckle() -> LinkShape:
    """The follower of the parallelogram, a tongue at its upper end."""
    y, z = INNER_KNUCKLE
    shank = (0.62 * y, 0.62 * z, 0.0060)
    return LinkShape(
        visual={
            "grey": (
                plate([(0.0, 0.0, 0.0072), shank], x=(-FORK[1], FORK[1])),
                plate([shank, (y, z, 0.0062)], x=(-TONGUE, TONGUE)),
            ),
        },
        collision=(_bar(INNER_KNUCKLE, 0.008, -0.008, 0.011, 2 * FORK[1]),),
    )


def _inner_finger() -> LinkShape:
    """The fingertip: a fork below, on two pins, and a back for the pad above."""
    pin = (*INNER_PIN, 0.0066)
    pad_back = PAD[0] + PAD_SIZE[1] / 2
    low, high = PAD[1] - PAD_SIZE[2] / 2, PAD[1] + PAD_SIZE[2] / 2
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
                plate(tongue, x=(-TONGUE, TONGUE)),
                plate(back, x=(-FORK[1], FORK[1]), chamfer=0.0008),
                *_both(prong, (FORK[0], FORK[1] - 0.0004)),
            ),
            "metal": (_pin(INNER_PIN, FORK[1] + 0.0008, 0.0034),),
        },
        collision=(
            Box(
                size=(2 * FORK[1], 0.0115, high - low - 0.001),
                xyz=(0.0, pad_back + 0.0005 + 0.0115 / 2, PAD[1]),
            ),
        ),
    )


def _inner_finger_pad() -> LinkShape:
    """The rubber pad; its collision box is what a grasped object touches."""
    x, y, z = (side / 2 for side in PAD_SIZE)
    edge = 0.0006
    corners: list[Circle] = [
        (sy * (y - edge), sz * (z - edge), edge) for sy in (-1, 1) for sz in (-1, 1)
    ]
    return LinkShape(
        visual={"rubber": (plate(corners, x=(-x, x), segments=8),)},
        collision=(Box(size=PAD_SIZE),),
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
    return turned(profile, axis="+x", at=(0.0, *at), segments=14)


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
