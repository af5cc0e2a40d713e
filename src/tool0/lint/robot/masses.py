"""Finds physically impossible masses and efforts, and bodies without mass."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import final

from tool0.description.finding import Finding, short
from tool0.description.model import Inertial
from tool0.lint.robot.elements import Subject, Tag, length
from tool0.lint.robot.facts import JointFacts, Robot

_WORLD = "world"
_DENSEST = 22600.0
"""Density of osmium, which is the densest element [kg/m³]:
https://en.wikipedia.org/wiki/Osmium."""
_ROUNDING = 1e-3
"""Relative tolerance of the triangle inequality.  The tolerance is needed because CAD
programs round numbers."""
_LONGEST = 10.0
_SIZES = (0.02, 3.0)
"""Plausible range of the radius of gyration, as a multiple of the link's size."""
_LIGHT = 0.5
"""Mass [kg] below which the links that a joint moves are considered a finger rather
than an arm."""
_STRONG = {"revolute": 100.0, "continuous": 100.0, "prismatic": 1000.0}
"""Effort that no motor of a finger reaches [N·m | N].  The largest effort of a 2F-85 is
23 N·m."""
_MOST_LINKS = 100
"""Largest number of links in a finger."""


def inertia_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the faults of the links' <inertial> elements."""
    facts, body = robot.facts, robot.body
    links = {link["name"]: link for link in robot.root.children("link")}
    masses = {name: _mass(link) for name, link in links.items()}
    heavy = {body.get(name) for name, mass in masses.items() if mass and mass > 0}
    geared = {link for box in facts.gearboxes for link in (box.parent, box.child)}
    for_gazebo = robot.is_spawned or facts.has_extensions or bool(facts.transmissions)
    for name, link in links.items():
        inertial, mass = link.child("inertial"), masses[name]
        for tag in ("mass", "inertia"):
            if inertial and not inertial.child(tag):
                yield inertial.at.error(
                    "incomplete-inertial",
                    f"the <inertial> of link '{short(name)}' has no <{tag}>, so ROS "
                    "refuses the whole robot_description",
                    f"add <{tag}>, or leave <inertial> out for a frame",
                )
        if mass is None:
            continue
        if mass > 0:
            yield from _tensor(
                link,
                mass,
                is_alone=body.get(name, name) == name,
                has_gear=name in geared,
            )
        elif mass < 0 or body.get(name) not in {*heavy, _WORLD}:
            yield inertial.child("mass").at.error(
                "bad-mass",
                f"link '{short(name)}' has the mass {mass:g} kg, "
                + (
                    "and nothing heavier is fixed to it: Gazebo drops it, and all that "
                    "hangs on it"
                    if mass == 0
                    else "which no body has"
                ),
                "give its mass in kg, or leave <inertial> out for a frame",
                severity="error" if mass < 0 or for_gazebo else "warning",
            )
    weighed = {name for name, link in links.items() if link.child("inertial")}
    if weighed or for_gazebo:  # otherwise, the robot is only displayed
        yield from _without(robot, weighed, for_gazebo)


@final
@dataclass(frozen=True, slots=True)
class _Body:
    """One link as a body, with mass [kg], principal moments [kg·m²], and extent [m]."""

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


def _moments(tensor: Tag, mass: float) -> tuple[float, float, float] | None:
    """Return the principal moments in ascending order; None if a number is missing."""
    given = [tensor.number(name) for name in ("ixx", "iyy", "izz")]
    given += [tensor.number(name, 0.0) for name in ("ixy", "ixz", "iyz")]
    found = [value for value in given if value is not None]
    if len(found) != len(given):
        return None
    scale = max(map(abs, found))
    if not scale > 0:
        return (0.0, 0.0, 0.0)
    # Because of this scale, and because rounding errors are set to 0, no power
    # overflows or underflows.
    values = [value / scale if abs(value) > 1e-9 * scale else 0.0 for value in found]
    ixx, iyy, izz, ixy, ixz, iyz = values
    low, middle, high = Inertial(
        mass=mass, ixx=ixx, iyy=iyy, izz=izz, ixy=ixy, ixz=ixz, iyz=iyz
    ).principal_moments
    return (low * scale, middle * scale, high * scale)


def _tensor(
    link: Tag, mass: float, *, is_alone: bool, has_gear: bool
) -> Iterator[Finding]:
    """Yield the findings about an inertia.  A merged inertia has fewer findings.

    With ``has_gear``, the link's inertia may include the inertia of a rotor.
    """
    tensor = link.child("inertial").child("inertia")
    moments = _moments(tensor, mass)
    if moments is None:
        return
    body = _Body(link["name"], mass, moments, _extent(link))
    low, middle, high = moments
    if not low > 0:
        yield tensor.at.error(
            "bad-inertia",
            f"{body}, where all must be above zero (positive definite): the "
            "simulator refuses it, or the robot flies apart",
            "check signs and products of inertia: ixy, ixz and iyz are small "
            "compared with ixx, iyy and izz",
            severity="error" if is_alone else "warning",
        )
    elif not low + middle >= high * (1 - _ROUNDING):
        yield tensor.at.warning(
            "bad-inertia",
            f"{body}: no body's largest exceeds the sum of the others (triangle "
            "inequality). MuJoCo and the new Gazebo refuse it, and Gazebo "
            "classic turns it wrongly",
            "check units and axes, and that a CAD program's signs are kept",
        )
    elif is_alone and (reason := _implausible(body, has_gear)):
        yield tensor.at.error(
            "implausible-inertia",
            f"{body}; {reason}",
            "give moments in kg·m² about the centre of mass, not in g·mm²: a solid "
            "box has mass/12·(a²+b²), a cylinder mass/2·r² about its axis",
            severity="error" if high < _moment_of_ball(mass) / 100 else "warning",
        )


def _implausible(body: _Body, has_gear: bool) -> str:
    """Return the reason why the radius of gyration is implausible, or an empty text."""
    high = body.moments[2]
    gyration = math.sqrt(high / body.mass)
    compact = _moment_of_ball(body.mass)
    if high < compact:
        return (
            f"a ball of osmium, the densest there is, has {compact:.3g} kg·m²: the "
            "moments are far too small, and the simulation will oscillate"
        )
    if gyration > _LONGEST:
        return (
            f"it lies {gyration:.3g} m around its centre (radius of gyration), so it "
            "hardly turns"
        )
    if body.extent and not (_SIZES[0] <= gyration / body.extent <= _SIZES[1]):
        much = "small" if gyration < body.extent else "large"
        if has_gear and much == "large":
            return ""
        return (
            f"its mass lies {gyration:.3g} m around its centre (radius of gyration), "
            f"while its shapes measure {body.extent:.3g} m: the moments are too {much} "
            f"for it"
        )
    return ""


def _moment_of_ball(mass: float) -> float:
    """Return the smallest moment [kg·m²] that a body of ``mass`` [kg] can have.

    For a given mass and density, the smallest moment is the moment of a solid ball.
    """
    radius: float = (3 * mass / (4 * math.pi * _DENSEST)) ** (1 / 3)
    return 0.4 * mass * radius * radius


def _without(
    robot: Robot, weighed: Collection[str], for_gazebo: bool
) -> Iterator[Finding]:
    """Yield the moving bodies and the supporting bodies that have no inertia."""
    facts, body = robot.facts, robot.body
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
            yield Subject(name, facts.links[name]).error(
                "no-inertia",
                f"link '{short(name)}' "
                + ("carries joints that move" if is_base else "moves")
                + ", yet neither it nor what is fixed to it has an <inertial>: "
                "Gazebo drops it, and all that hangs on it",
                "give it <inertial> with mass and inertia"
                + (', or fix it to <link name="world"/>' * is_base),
                severity="error" if for_gazebo else "warning",
            )


def _mass(link: Tag) -> float | None:
    """Return the mass of ``link`` [kg]; None if it is missing or not a number."""
    return link.child("inertial").child("mass").number("value")


def _extent(link: Tag) -> float | None:
    """Return the approximate length of ``link`` [m]; None if it is unknown.

    The length is computed from the collision shapes.  If some collision shapes are
    meshes, the length is computed from the visual shapes.
    """
    for tag in ("collision", "visual"):
        balls = [(_origin(owner), _diameter(owner)) for owner in link.children(tag)]
        known = [(centre, size) for centre, size in balls if size is not None]
        if known and len(known) == len(balls):
            return max(
                max(centre[axis] + size / 2 for centre, size in known)
                - min(centre[axis] - size / 2 for centre, size in known)
                for axis in range(3)
            )
    return None


def _origin(owner: Tag) -> tuple[float, ...]:
    return owner.child("origin").vector("xyz") or (0.0, 0.0, 0.0)


def _diameter(owner: Tag) -> float | None:
    """Return the diameter of the bounding sphere of a shape [m]; None for a mesh."""
    geometry = owner.child("geometry")
    box = geometry.child("box").vector("size")
    if box is not None and min(box) > 0:
        return length(box)
    for tag in ("cylinder", "sphere"):
        shape = geometry.child(tag)
        radius, along = shape.number("radius"), shape.number("length", 0.0)
        if radius is None or radius <= 0:
            continue
        if tag == "sphere":
            return 2 * radius
        if along is not None and along > 0:
            return length((2 * radius, along))
    return None


def _reach(link: Tag) -> float:
    """Return the largest distance of the link's parts from the link's origin [m].

    Meshes are not opened.  For a mesh, only its origin is used.  The center of mass is
    also used.
    """
    shapes = [*link.children("collision"), *link.children("visual")]
    reaches = [length(_origin(o)) + (_diameter(o) or 0.0) / 2 for o in shapes]
    return max(length(_origin(link.child("inertial"))), *reaches, 0.0)


def effort_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the finger joints with an effort limit that no real finger has."""
    links = {link["name"]: link for link in robot.root.children("link")}
    in_reverse = reversed(list(robot.root.children("joint")))
    # reversed, so that the first of several joints with the same name is used
    tags = {joint["name"]: joint for joint in in_reverse}
    below: dict[str, list[JointFacts]] = {}
    for joint in robot.facts.joints.values():
        below.setdefault(joint.parent, []).append(joint)

    def load(start: str) -> tuple[float, float] | None:
        """Return the mass [kg] and reach [m] of a link and all links beyond it.

        The result is None for an arm.
        """
        mass = reach = 0.0
        seen: set[str] = set()
        waiting = [(start, 0.0)]
        while waiting:
            name, away = waiting.pop()
            if name not in links or name in seen:
                continue
            seen.add(name)
            mass += max(0.0, _mass(links[name]) or 0.0)
            if mass >= _LIGHT or len(seen) > _MOST_LINKS:
                return None
            reach = max(reach, away + _reach(links[name]))
            for joint in below.get(name, ()):
                waiting.append((joint.child, away + length(_origin(tags[joint.name]))))
        return (mass, reach) if mass > 0 else None

    for joint in robot.facts.joints.values():
        limit = tags[joint.name].child("limit")
        effort, strong = limit.number("effort"), _STRONG.get(joint.type)
        if joint.mimic_of is not None or effort is None or strong is None:
            continue
        moved = load(joint.child) if effort >= strong else None
        if moved is not None:
            yield _too_strong(joint, limit, effort, *moved)


def _too_strong(
    joint: JointFacts, limit: Tag, effort: float, mass: float, reach: float
) -> Finding:
    unit = "N" if joint.type == "prismatic" else "N·m"
    message = (
        f"joint '{short(joint.name)}' may exert {effort:g} {unit} on {mass:.3g} kg"
    )
    if unit == "N·m" and reach > 1e-3:
        message += (
            f" that reaches {reach:.2g} m at most, which is "
            f"{effort / reach:.0f} N or more at its tip"
        )
    return limit.at.warning(
        "absurd-effort",
        f"{message}: its limit stops nothing, so a controller crushes or throws "
        "what it touches",
        f"give the motor's own limit in {unit}; that of a Robotiq 2F-85, whose "
        "fingers press with 235 N, is about 23 N·m",
    )
