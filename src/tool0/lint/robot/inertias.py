"""Masses and inertias that no body could have, and bodies without any."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import final
from xml.dom.minidom import Element

from tool0.description.finding import Finding, Severity, error_at, short, warning_at
from tool0.description.model import Inertial
from tool0.description.xml_source import children
from tool0.lint.robot.bodies import bodies, extent_of
from tool0.lint.robot.elements import attribute, child, number, place
from tool0.lint.robot.facts import RobotFacts

_WORLD = "world"
_DENSEST = 22600.0
"""Of osmium [kg/m³]: https://en.wikipedia.org/wiki/Osmium."""
_ROUNDING = 1e-3
"""The slack of the triangle inequality, for numbers that a CAD program rounded."""
_LONGEST = 10.0
_SIZES = (0.02, 3.0)
"""How far the radius of gyration may be from the link's own size, as a factor of it."""


def inertia_findings(
    root: Element, facts: RobotFacts, spawned: bool
) -> Iterator[Finding]:
    """Yield what is wrong in the links' <inertial>."""
    links = {attribute(link, "name"): link for link in children(root, "link")}
    body = bodies(facts)
    masses = {name: _mass(link) for name, link in links.items()}
    heavy = {body.get(name) for name, mass in masses.items() if mass and mass > 0}
    for_gazebo = spawned or facts.has_extensions or bool(facts.transmissions)
    for name, link in links.items():
        inertial = child(link, "inertial")
        if inertial is None:
            continue
        is_alone = body.get(name, name) == name
        yield from _incomplete(inertial, name)
        mass = masses[name]
        if mass is None:
            continue
        if mass > 0:
            yield from _tensor(link, inertial, name, mass, is_alone)
        elif mass < 0 or body.get(name) not in {*heavy, _WORLD}:
            severity: Severity = "error" if mass < 0 or for_gazebo else "warning"
            yield _bad_mass(inertial, name, mass, severity)
    yield from _without(facts, links, for_gazebo)


def _mass(link: Element) -> float | None:
    return number(child(child(link, "inertial"), "mass"), "value")


def _incomplete(inertial: Element, name: str) -> Iterator[Finding]:
    for tag in ("mass", "inertia"):
        if child(inertial, tag) is None:
            yield error_at(
                place(inertial),
                "incomplete-inertial",
                name,
                f"the <inertial> of link '{short(name)}' has no <{tag}>, so ROS "
                "refuses the whole robot_description",
                f"add <{tag}>, or leave <inertial> out for a mere frame",
            )


def _bad_mass(inertial: Element, name: str, mass: float, severity: Severity) -> Finding:
    return Finding(
        location=place(child(inertial, "mass") or inertial),
        rule="bad-mass",
        severity=severity,
        key=name,
        message=(
            f"link '{short(name)}' has the mass {mass:g} kg, and nothing heavier is "
            "fixed to it: Gazebo drops it, and all that hangs on it"
            if mass == 0
            else f"link '{short(name)}' has the mass {mass:g} kg, which no body has"
        ),
        remedy="give its mass in kg, or leave <inertial> out for a mere frame",
    )


@final
@dataclass(frozen=True, slots=True)
class _Body:
    """One link as a body: a name, kg, principal moments [kg·m²], extent [m]."""

    name: str
    mass: float
    moments: tuple[float, float, float]
    extent: float | None

    def __str__(self) -> str:
        low, middle, high = self.moments
        return (
            f"link '{short(self.name)}' of {self.mass:g} kg has the principal moments "
            f"{low:.3g}, {middle:.3g} and {high:.3g} kg·m²"
        )


def _moments(tensor: Element, mass: float) -> tuple[float, float, float] | None:
    """Return the principal moments, smallest first; None if a number is missing."""
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    given = [number(tensor, name) if attribute(tensor, name) else 0.0 for name in names]
    found = [value for value in given if value is not None]
    if len(found) != len(names) or any(
        not attribute(tensor, name) for name in names[:3]
    ):
        return None
    scale = max(map(abs, found))
    if not scale > 0:
        return (0.0, 0.0, 0.0)
    # So scaled, and without what is less than rounding, no power over- or underflows.
    values = [value / scale if abs(value) > 1e-9 * scale else 0.0 for value in found]
    ixx, iyy, izz, ixy, ixz, iyz = values
    low, middle, high = Inertial(
        mass=mass, ixx=ixx, iyy=iyy, izz=izz, ixy=ixy, ixz=ixz, iyz=iyz
    ).principal_moments
    return (low * scale, middle * scale, high * scale)


def _tensor(
    link: Element, inertial: Element, name: str, mass: float, is_alone: bool
) -> Iterator[Finding]:
    """Yield what is wrong with the inertia; less if it is merged into another."""
    tensor = child(inertial, "inertia")
    moments = None if tensor is None else _moments(tensor, mass)
    if tensor is None or moments is None:
        return
    body = _Body(name, mass, moments, extent_of(link))
    low, middle, high = moments
    if not low > 0:
        finding_at = error_at if is_alone else warning_at
        yield finding_at(
            place(tensor),
            "bad-inertia",
            name,
            f"{body}, where all must be above zero (positive definite): the "
            "simulator refuses it, or throws the robot away",
            "check signs and products of inertia: ixy, ixz and iyz are small "
            "beside ixx, iyy and izz",
        )
    elif not low + middle >= high * (1 - _ROUNDING):
        yield warning_at(
            place(tensor),
            "bad-inertia",
            name,
            f"{body}: no body's largest exceeds the sum of the others (triangle "
            "inequality). MuJoCo and the new Gazebo refuse it, and Gazebo "
            "classic turns it wrongly",
            "check units and axes, and that a CAD program's signs are kept",
        )
    elif is_alone:
        yield from _size(tensor, body)


def _size(tensor: Element, body: _Body) -> Iterator[Finding]:
    """Compare the radius of gyration with sizes that a body may have."""
    high = body.moments[2]
    gyration = math.sqrt(high / body.mass)
    compact = _moment_of_ball(body.mass)
    if high < compact:
        yield _implausible(
            tensor,
            body,
            f"a ball of osmium, the densest there is, has {compact:.3g} kg·m²: the "
            "moments are too small by far, and the simulation will shake",
            is_error=high < compact / 100,
        )
    elif gyration > _LONGEST:
        yield _implausible(
            tensor,
            body,
            f"it lies {gyration:.3g} m around its centre (radius of gyration), so it "
            "hardly turns",
        )
    elif body.extent and not (_SIZES[0] <= gyration / body.extent <= _SIZES[1]):
        much = "small" if gyration < body.extent else "large"
        yield _implausible(
            tensor,
            body,
            f"its mass lies {gyration:.3g} m around its centre (radius of gyration), "
            f"while its shapes measure {body.extent:.3g} m: the moments are too {much} "
            f"for it",
        )


def _implausible(
    tensor: Element, body: _Body, reason: str, *, is_error: bool = False
) -> Finding:
    finding_at = error_at if is_error else warning_at
    return finding_at(
        place(tensor),
        "implausible-inertia",
        body.name,
        f"{body}; {reason}",
        "give moments in kg·m² about the centre of mass, not in g·mm²: a solid "
        "box has mass/12·(a²+b²), a cylinder mass/2·r² about its axis",
    )


def _moment_of_ball(mass: float) -> float:
    """Return the least moment [kg·m²] that a body of ``mass`` [kg] can have.

    For a given mass and density, that of a solid ball.
    """
    radius: float = (3 * mass / (4 * math.pi * _DENSEST)) ** (1 / 3)
    return 0.4 * mass * radius * radius


def _without(
    facts: RobotFacts, links: Mapping[str, Element], for_gazebo: bool
) -> Iterator[Finding]:
    """Yield the bodies that move, or that all hangs on, and have no inertia."""
    weighed = {name for name, link in links.items() if child(link, "inertial")}
    if not (weighed or for_gazebo):
        return  # drawn only
    body = bodies(facts)
    heavy = {body[name] for name in weighed if name in body}
    moved = {joint.child for joint in facts.joints.values() if facts.moves(joint)}
    carriers = {
        body.get(joint.parent) for joint in facts.joints.values() if joint.is_movable
    }
    for name in dict.fromkeys(body.values()):
        if name in heavy or name == _WORLD:
            continue
        is_base = name in carriers and name not in moved
        if name in moved or (is_base and for_gazebo):
            finding_at = error_at if for_gazebo else warning_at
            yield finding_at(
                facts.links[name],
                "no-inertia",
                name,
                f"link '{short(name)}' "
                + ("carries joints that move" if is_base else "moves")
                + ", yet neither it nor what is fixed to it has an <inertial>: "
                "Gazebo drops it, and all that hangs on it",
                "give it <inertial> with mass and inertia"
                + (', or fix it to <link name="world"/>' * is_base),
            )
