"""How large a link is, and how strong a joint is beside what it moves."""

from __future__ import annotations

from collections.abc import Iterator

from tool0.description.finding import Finding, short
from tool0.lint.robot.elements import Tag, length
from tool0.lint.robot.facts import JointFacts, Robot

_LIGHT = 0.5
"""Moving mass below which a joint is a finger rather than an arm [kg]."""
_STRONG = {"revolute": 100.0, "continuous": 100.0, "prismatic": 1000.0}
"""Efforts that no motor of such a finger has [N·m | N]: a 2F-85 has 23 N·m at most."""
_MOST_LINKS = 100
"""Of a finger; a longer chain is no finger."""


def mass_of(link: Tag) -> float | None:
    """Return the mass of ``link`` [kg]; None if it has none, or no number."""
    return link.child("inertial").child("mass").number("value")


def extent_of(link: Tag) -> float | None:
    """Return about how long ``link`` is [m]; None if it is not known.

    The shapes that it collides with count; if some are meshes, those that are drawn.
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
    """Return the diameter [m] of the ball around a shape; None of a mesh."""
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
    """Return how far from the link's origin anything of it is, at most [m].

    Meshes are not opened: of them only the origin counts, and the centre of mass.
    """
    shapes = [*link.children("collision"), *link.children("visual")]
    reaches = [length(_origin(o)) + (_diameter(o) or 0.0) / 2 for o in shapes]
    return max(length(_origin(link.child("inertial"))), *reaches, 0.0)


def effort_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the joints whose effort limit cannot be that of a real finger."""
    links = {link["name"]: link for link in robot.root.children("link")}
    in_reverse = reversed(list(robot.root.children("joint")))
    tags = {joint["name"]: joint for joint in in_reverse}  # so that the first counts
    below: dict[str, list[JointFacts]] = {}
    for joint in robot.facts.joints.values():
        below.setdefault(joint.parent, []).append(joint)

    def load(start: str) -> tuple[float, float] | None:
        """Return mass [kg] and reach [m] of what hangs on a link; None for an arm."""
        mass = reach = 0.0
        seen: set[str] = set()
        waiting = [(start, 0.0)]
        while waiting:
            name, away = waiting.pop()
            if name not in links or name in seen:
                continue
            seen.add(name)
            mass += max(0.0, mass_of(links[name]) or 0.0)
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
