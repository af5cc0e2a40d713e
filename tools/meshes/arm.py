"""A Universal Robots arm: aluminium tubes between capped joint housings.

Every joint housing is a cylinder around its joint's axis. One end carries a lid, the
other turns against the next link across a dark ring; a tube leaves from its side.
The numbers below are proportions, so that any arm of the family can be drawn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from .arm_parameters import ArmParameters
from .model import Cylinder, LinkShape, ModelShape, Primitive, Vector
from .solid import Solid, rounded
from .solid import turned as turned_solid

Colour = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """What a generation of arms has in common; lengths in radii of the housing."""

    grey: Colour
    """Of housings and tubes."""
    blue: Colour
    """Of lids."""
    lid: float
    """Height of a lid."""
    rounding: float
    """Share of the lid's height that its edge is rounded by."""
    bevel: float = 0.0
    """Instead of the rounding: how far a flat bevel goes inwards."""
    seam: float = 0.05
    """Height of the dark seam below a lid."""
    band: float = 0.0
    """Height of the dark band where a housing turns against the next link."""

    @property
    def materials(self) -> Mapping[str, Colour]:
        return {"grey": self.grey, "blue": self.blue, "black": BLACK}


BLACK = (0.12, 0.12, 0.13, 1.0)
STYLES = {
    "cb3": Style(
        grey=(0.75, 0.76, 0.78, 1.0),
        blue=(0.45, 0.62, 0.74, 1.0),
        lid=0.22,
        rounding=0.55,
    ),
    "e_series": Style(
        grey=(0.86, 0.87, 0.88, 1.0),
        blue=(0.66, 0.76, 0.83, 1.0),
        lid=0.36,
        rounding=0.95,
        seam=0.09,
        band=0.16,
    ),
    "large": Style(
        grey=(0.80, 0.82, 0.84, 1.0),
        blue=(0.25, 0.34, 0.43, 1.0),
        lid=0.30,
        rounding=0.0,
        bevel=0.26,
        seam=0.04,
        band=0.07,
    ),
}
GAP = 0.004
"""Width of the dark ring at a joint [m]."""
turned = partial(turned_solid, segments=24)
_RPY: dict[str, Vector] = {
    "x": (0.0, math.pi / 2, 0.0),
    "y": (math.pi / 2, 0.0, 0.0),
    "z": (0.0, 0.0, 0.0),
}


def arm_shape(arm: ArmParameters) -> ModelShape:
    """Return the shapes of all links of an arm."""
    return ModelShape(
        kind="arms",
        name=arm.name,
        materials=STYLES[arm.style].materials,
        links={
            "base": _base(arm),
            "shoulder": _shoulder(arm),
            "upper_arm": _upper_arm(arm),
            "forearm": _forearm(arm),
            "wrist_1": _wrist_1(arm),
            "wrist_2": _wrist_2(arm),
            "wrist_3": _wrist_3(arm),
        },
    )


def _base(arm: ArmParameters) -> LinkShape:
    """A foot plate, a short body, and the socket of the cable at the back."""
    top, foot = arm.d1 - _shoulder_drop(arm), 0.14 * arm.foot_radius
    radius = arm.shoulder_radius
    body = [(radius * 1.07, foot * 0.5), (radius * 1.07, foot * 1.3)]
    plug = 0.13 * radius
    return LinkShape(
        visual={
            "grey": (
                turned(rounded(arm.foot_radius, 0.0, foot, above=0.2 * foot)),
                turned([*body, (radius, foot * 1.8), (radius, top - GAP)]),
            ),
            "black": (
                _ring(radius, top - GAP, "+z"),
                turned(
                    rounded(plug, 0.0, radius + 1.5 * plug),
                    axis="-y",
                    at=(0.0, 0.0, foot + plug),
                    segments=12,
                ),
            ),
        },
        collision=(
            _cylinder(arm.foot_radius, 0.0, foot, "z"),
            _cylinder(radius, foot, top - GAP, "z"),
        ),
    )


def _shoulder(arm: ArmParameters) -> LinkShape:
    """An upright housing with its lid on top, and a neck towards the upper arm."""
    radius, drop = arm.shoulder_radius, _shoulder_drop(arm)
    neck, reach = 0.97 * radius, arm.upper_arm_offset / 2 - GAP
    style = STYLES[arm.style]
    housing = _housing(style, radius, -drop, 0.86 * radius, "+z")
    return LinkShape(
        visual={
            "grey": (
                housing.body,
                turned(_flared(neck, 0.0, reach), axis="-y"),
            ),
            "blue": (housing.lid,),
            "black": (*housing.dark, _ring(neck, reach, "-y")),
        },
        collision=(
            _cylinder(radius, -drop, (0.86 + style.lid) * radius, "z"),
            _cylinder(neck, -reach, 0.0, "y"),
        ),
    )


def _upper_arm(arm: ArmParameters) -> LinkShape:
    """Two housings with their lids outwards, and the thick tube between them."""
    z, tube = arm.upper_arm_offset, arm.upper_arm_radius
    elbow_face = (arm.upper_arm_offset + arm.forearm_offset) / 2
    r_shoulder, r_elbow = arm.shoulder_radius, arm.elbow_radius
    elbow = (-arm.a2, 0.0, 0.0)
    shoulder_top, elbow_top = z + 0.86 * r_shoulder, z + 0.9 * r_elbow
    style = STYLES[arm.style]
    near = _housing(style, r_shoulder, z / 2, shoulder_top, "+z")
    far = _housing(style, r_elbow, elbow_face + GAP, elbow_top, "+z", at=elbow)
    tops = shoulder_top + style.lid * r_shoulder, elbow_top + style.lid * r_elbow
    return LinkShape(
        visual={
            "grey": (
                near.body,
                far.body,
                _tube(arm.a2, (tube, tube), (r_shoulder, r_elbow), z),
            ),
            "blue": (near.lid, far.lid),
            "black": (
                *near.dark,
                *far.dark,
                _ring(r_elbow, -elbow_face - GAP, "-z", at=elbow),
            ),
        },
        collision=(
            _cylinder(r_shoulder, z / 2, tops[0], "z"),
            _cylinder(tube, -arm.a2, 0.0, "x", at=(0.0, 0.0, z)),
            _cylinder(r_elbow, elbow_face + GAP, tops[1], "z", elbow),
        ),
    )


def _forearm(arm: ArmParameters) -> LinkShape:
    """A rounded bend at the elbow, a slim tube, and the first wrist's housing."""
    z, radii = arm.forearm_offset, (arm.forearm_radius, 0.88 * arm.forearm_radius)
    face = (arm.upper_arm_offset + arm.forearm_offset) / 2
    wrist_face = (arm.forearm_offset + arm.d4) / 2
    bend, wrist = 0.94 * arm.elbow_radius, arm.wrist_radius
    low, wrist_low = z - 0.92 * bend, z - 0.9 * wrist
    end = (-arm.a3, 0.0, 0.0)
    style = STYLES[arm.style]
    housing = _housing(style, wrist, -wrist_face + GAP, -wrist_low, "-z", at=end)
    return LinkShape(
        visual={
            "grey": (
                turned(rounded(bend, low, face, below=0.45 * bend)),
                housing.body,
                _tube(arm.a3, radii, (bend, wrist), z),
            ),
            "blue": (housing.lid,),
            "black": (
                *housing.dark,
                _ring(wrist, wrist_face - GAP, "+z", at=end),
            ),
        },
        collision=(
            _cylinder(bend, low, face, "z"),
            _cylinder(radii[0], -arm.a3, 0.0, "x", at=(0.0, 0.0, z)),
            _cylinder(wrist, wrist_low - style.lid * wrist, wrist_face - GAP, "z", end),
        ),
    )


def _wrist_1(arm: ArmParameters) -> LinkShape:
    """The second wrist's housing, its lid away from it, on a neck to the forearm."""
    return _wrist(arm, (arm.d4 - arm.forearm_offset) / 2, arm.d5 / 2, "-y")


def _wrist_2(arm: ArmParameters) -> LinkShape:
    """The third wrist's housing, likewise, on a neck to the first."""
    return _wrist(arm, arm.d5 / 2, _flange_face(arm), "+y")


def _wrist(arm: ArmParameters, neck: float, face: float, axis: str) -> LinkShape:
    """A housing along y that turns against the next link at ``face`` [m]."""
    back = {"+y": "-y", "-y": "+y"}[axis]
    style, radius = STYLES[arm.style], arm.wrist_radius
    housing = _housing(style, radius, -face + GAP, 0.98 * radius, back)
    sign = 1.0 if axis == "+y" else -1.0
    ends = (sign * (face - GAP), -sign * (0.98 + style.lid) * radius)
    slim = 0.95 * radius
    return LinkShape(
        visual={
            "grey": (housing.body, turned(_flared(slim, 0.0, neck), axis="-z")),
            "blue": (housing.lid,),
            "black": (*housing.dark, _ring(radius, face - GAP, axis)),
        },
        collision=(
            _cylinder(radius, min(ends), max(ends), "y"),
            _cylinder(slim, -neck, 0.0, "z"),
        ),
    )


def _wrist_3(arm: ArmParameters) -> LinkShape:
    """The tool flange and its socket; the mounting face is the plane z = 0."""
    low, radius = _flange_face(arm) - arm.d6, arm.flange_radius
    step, boss = 0.15 * low, 0.84 * radius
    body = rounded(radius, low, step, above=0.06 * radius)
    plug = 0.16 * radius
    bolts = tuple(
        turned(
            rounded(0.09 * radius, low / 2, -0.0002),
            at=(0.47 * radius * sx, 0.47 * radius * sy, 0.0),
            segments=8,
        )
        for sx in (-1, 1)
        for sy in (-1, 1)
    )
    return LinkShape(
        visual={
            "grey": (turned([*body, (boss, step), (boss, -0.0005)]),),
            "black": (
                turned(
                    rounded(plug, 0.0, radius + plug, above=0.3 * plug),
                    axis="+y",
                    at=(0.0, 0.0, 0.62 * low),
                    segments=12,
                ),
                *bolts,
            ),
        },
        collision=(_cylinder(radius, low, 0.0, "z"),),
    )


def _shoulder_drop(arm: ArmParameters) -> float:
    """Depth of the shoulder's lower face below its lift axis [m]."""
    return max(0.97 * arm.shoulder_radius, 0.5 * arm.d1)


def _flange_face(arm: ArmParameters) -> float:
    """Distance from the wrist 2 axis at which the tool flange begins [m]."""
    return 1.08 * arm.wrist_radius


class Housing(NamedTuple):
    """A joint's housing, with the lid on its far end."""

    body: Solid
    lid: Solid
    dark: tuple[Solid, ...]
    """The seam below the lid, and the band at the joint."""


def _housing(
    style: Style,
    radius: float,
    low: float,
    high: float,
    axis: str,
    *,
    at: Vector = (0.0, 0.0, 0.0),
) -> Housing:
    """Return a housing along ``axis`` that turns against the next link at ``low``."""
    seam, lid, band = style.seam * radius, style.lid * radius, style.band * radius
    if style.bevel:
        inwards, step = style.bevel * radius, 0.25 * (lid - seam)
        edge = [(radius, high + seam), (radius, high + seam + step)]
        lid_profile = [*edge, (radius - inwards, high + lid)]
    else:
        above = style.rounding * (lid - seam)
        lid_profile = rounded(radius, high + seam, high + lid, above=above)
    body = rounded(radius, low + band, high, above=min(0.04 * radius, 0.003))
    dark = [rounded(0.97 * radius, high, high + seam)]
    if band:
        dark.append(rounded(0.99 * radius, low, low + band))
    return Housing(
        body=turned(body, axis=axis, at=at),
        lid=turned(lid_profile, axis=axis, at=at),
        dark=tuple(turned(profile, axis=axis, at=at) for profile in dark),
    )


def _ring(radius: float, low: float, axis: str, at: Vector = (0.0, 0.0, 0.0)) -> Solid:
    """Return the dark ring that fills a joint's gap."""
    return turned(rounded(0.98 * radius, low, low + GAP), axis=axis, at=at)


def _flared(radius: float, low: float, high: float) -> list[tuple[float, float]]:
    """Return the profile of a neck that widens into a collar at its end."""
    collar = 0.16 * radius
    slim = 0.93 * radius
    return [
        (slim, low),
        (slim, high - 1.6 * collar),
        (radius, high - collar),
        (radius, high),
    ]


def _tube(
    length: float, radii: tuple[float, float], housings: tuple[float, float], z: float
) -> Solid:
    """Return the tube along -x, with a collar where it enters either housing."""
    (r0, r1), (h0, h1) = radii, housings
    profile = [
        (1.12 * r0, 0.0),
        (1.12 * r0, 1.15 * h0),
        (r0, 1.3 * h0),
        (r1, length - 1.3 * h1),
        (1.12 * r1, length - 1.15 * h1),
        (1.12 * r1, length),
    ]
    return turned(profile, axis="-x", at=(0.0, 0.0, z))


def _cylinder(
    radius: float,
    low: float,
    high: float,
    axis: str,
    at: Vector = (0.0, 0.0, 0.0),
) -> Primitive:
    """Return the cylinder from ``low`` to ``high`` along an axis through ``at``."""
    middle = (low + high) / 2
    x, y, z = at
    xyz = {"x": (x + middle, y, z), "y": (x, y + middle, z), "z": (x, y, z + middle)}
    return Cylinder(radius=radius, length=high - low, xyz=xyz[axis], rpy=_RPY[axis])
