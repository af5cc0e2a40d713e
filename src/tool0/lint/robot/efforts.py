"""Efforts far beyond what so light a thing can need."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final
from xml.dom.minidom import Element

from tool0.description.finding import Finding, warning_at
from tool0.description.xml_source import children
from tool0.lint.robot.elements import attribute, child, length, number, vector
from tool0.lint.robot.facts import JointFacts, RobotFacts
from tool0.lint.robot.names import short
from tool0.lint.robot.shapes import reach_of

_LIGHT = 0.5
"""Moving mass below which a joint is a finger rather than an arm [kg]."""
_STRONG = {"revolute": 100.0, "continuous": 100.0, "prismatic": 1000.0}
"""Efforts that no motor of such a finger has [N·m | N]: a 2F-85 has 23 N·m at most."""
_MOST_LINKS = 100
"""Of a finger; what is longer is not looked at."""


@final
@dataclass(frozen=True, slots=True)
class _Load:
    """What a joint moves: mass [kg], and how far from its axis at most [m]."""

    mass: float
    reach: float


def effort_findings(root: Element, facts: RobotFacts) -> Iterator[Finding]:
    """Yield the joints whose effort limit cannot be that of a real finger."""
    links = {attribute(link, "name"): link for link in children(root, "link")}
    origins = {
        attribute(joint, "name"): length(
            vector(child(joint, "origin"), "xyz") or (0.0,)
        )
        for joint in children(root, "joint")
    }
    below: dict[str, list[JointFacts]] = {}
    for joint in facts.joints.values():
        below.setdefault(joint.parent, []).append(joint)
    for joint in facts.joints.values():
        effort = joint.limits.effort if joint.limits else None
        strong = _STRONG.get(joint.type)
        if joint.mimic_of is not None or effort is None or strong is None:
            continue
        if effort < strong:
            continue
        load = _load(joint.child, links, below, origins)
        if load is not None and load.mass < _LIGHT:
            yield _too_strong(joint, effort, load)


def _load(
    start: str,
    links: dict[str, Element],
    below: dict[str, list[JointFacts]],
    origins: dict[str, float],
) -> _Load | None:
    """Return what hangs on the link ``start``; None if it is an arm, or weightless."""
    mass = reach = 0.0
    seen: set[str] = set()
    waiting = [(start, 0.0)]
    while waiting:
        name, away = waiting.pop()
        link = links.get(name)
        if link is None or name in seen:
            continue
        seen.add(name)
        mass += max(0.0, number(child(child(link, "inertial"), "mass"), "value") or 0.0)
        if mass >= _LIGHT or len(seen) > _MOST_LINKS:
            return None
        reach = max(reach, away + reach_of(link))
        waiting.extend(
            (joint.child, away + origins.get(joint.name, 0.0))
            for joint in below.get(name, ())
        )
    return _Load(mass, reach) if mass > 0 else None


def _too_strong(joint: JointFacts, effort: float, load: _Load) -> Finding:
    unit = "N" if joint.type == "prismatic" else "N·m"
    message = (
        f"joint '{short(joint.name)}' may exert {effort:g} {unit} on {load.mass:.3g} kg"
    )
    if unit == "N·m" and load.reach > 1e-3:
        message += (
            f" that reaches {load.reach:.2g} m at most, which is "
            f"{effort / load.reach:.0f} N or more at its tip"
        )
    return warning_at(
        joint.limits.location if joint.limits else joint.location,
        "absurd-effort",
        joint.name,
        f"{message}: its limit stops nothing, so a controller crushes or throws "
        "what it touches",
        f"give the motor's own limit in {unit}; that of a Robotiq 2F-85, whose "
        "fingers press with 235 N, is about 23 N·m",
    )
