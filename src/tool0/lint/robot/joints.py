"""Joints that ROS cannot read or that never move: types, limits, numbers, efforts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at, short, warning_at
from tool0.description.xml_source import children
from tool0.errors import nearest_name
from tool0.lint.robot.bodies import reach_of
from tool0.lint.robot.elements import (
    attribute,
    child,
    descendants,
    is_number,
    length,
    number,
    place,
    vector,
)
from tool0.lint.robot.facts import MOVABLE, JointFacts, RobotFacts

_TYPES = (*MOVABLE, "fixed")
_LIMITED = ("revolute", "prismatic")
_FASTEST = {"revolute": 100.0, "continuous": 1000.0, "prismatic": 20.0}
"""[rad/s | m/s]; an arm's joint turns at 3 rad/s, and a gripper's at 2."""
_COUNTS: dict[str, dict[str, int]] = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "effort": 1, "velocity": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "safety_controller": {
        "soft_lower_limit": 1,
        "soft_upper_limit": 1,
        "k_position": 1,
        "k_velocity": 1,
    },
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "mesh": {"scale": 3},
}
_LIGHT = 0.5
"""Moving mass below which a joint is a finger rather than an arm [kg]."""
_STRONG = {"revolute": 100.0, "continuous": 100.0, "prismatic": 1000.0}
"""Efforts that no motor of such a finger has [N·m | N]: a 2F-85 has 23 N·m at most."""
_MOST_LINKS = 100
"""Of a finger; a longer chain is no finger."""


def joint_findings(root: Element, facts: RobotFacts) -> Iterator[Finding]:
    """Yield what is wrong in the joints themselves."""
    driven = facts.driven_joints
    for joint in children(root, "joint"):
        name, kind = attribute(joint, "name"), attribute(joint, "type")
        yield from _type(joint, name, kind)
        if kind in MOVABLE:
            yield from _axis(joint, name)
        if kind in _FASTEST:
            yield from _limit(joint, name, kind)
            if name in driven:  # 0 is what people write for one that nothing drives
                yield from _no_power(joint, name)


def _type(joint: Element, name: str, kind: str) -> Iterator[Finding]:
    if kind not in _TYPES:
        close = nearest_name(kind, _TYPES)
        yield error_at(
            place(joint),
            "unknown-joint-type",
            name,
            f"joint '{short(name)}' has the type '{short(kind)}', which URDF does "
            "not know, so ROS refuses the whole robot_description",
            f'write type="{close}"' if close else f"write {', '.join(_TYPES)}",
        )


def _axis(joint: Element, name: str) -> Iterator[Finding]:
    axis = child(joint, "axis")
    direction = vector(axis, "xyz")
    if axis is not None and direction is not None and not any(direction):
        yield error_at(
            place(axis),
            "zero-axis",
            name,
            f"the axis of joint '{short(name)}' has no direction, so that it turns "
            "about none",
            'give it one, such as <axis xyz="0 0 1"/>',
        )


def _limit(joint: Element, name: str, kind: str) -> Iterator[Finding]:
    limit = child(joint, "limit")
    needed = ("effort", "velocity")
    if limit is None:
        if kind in _LIMITED:
            yield error_at(
                place(joint),
                "no-limit",
                name,
                f"{kind} joint '{short(name)}' has no <limit>, so ROS refuses the "
                "whole robot_description",
                'write <limit lower="…" upper="…" effort="…" velocity="…"/>'
                + ("; without end is type continuous" * (kind == "revolute")),
            )
        return
    missing = [item for item in needed if not attribute(limit, item)]
    if missing:
        yield error_at(
            place(limit),
            "no-limit",
            name,
            f"the <limit> of joint '{short(name)}' lacks {' and '.join(missing)}, "
            "so ROS refuses the whole robot_description",
            "give it " + " ".join(f'{item}="…"' for item in missing),
        )
    yield from _range(limit, name, kind)
    velocity = number(limit, "velocity")
    if velocity is not None and velocity > _FASTEST[kind]:
        unit = "m/s" if kind == "prismatic" else "rad/s"
        yield warning_at(
            place(limit),
            "absurd-velocity",
            name,
            f"joint '{short(name)}' may move at {velocity:g} {unit}, so its limit "
            "stops nothing that goes wrong",
            f"give the real joint's speed in {unit}, not in degrees or mm",
        )


def _range(limit: Element, name: str, kind: str) -> Iterator[Finding]:
    if kind not in _LIMITED:
        return
    lower = number(limit, "lower") if attribute(limit, "lower") else 0.0
    upper = number(limit, "upper") if attribute(limit, "upper") else 0.0
    if lower is None or upper is None:
        return
    if lower > upper:
        yield error_at(
            place(limit),
            "limits-swapped",
            name,
            f"joint '{short(name)}' has its lower limit {lower:g} above its upper "
            f"{upper:g}: there is nowhere it may be",
            f'write lower="{upper:g}" upper="{lower:g}"',
        )
    elif lower == upper:
        yield warning_at(
            place(limit),
            "no-range",
            name,
            f"joint '{short(name)}' may only be at {lower:g}, so it never moves; "
            "what is not written is 0",
            'give lower="…" and upper="…", or make it type="fixed"',
        )


def _no_power(joint: Element, name: str) -> Iterator[Finding]:
    limit = child(joint, "limit")
    for what in ("effort", "velocity"):
        value = number(limit, what)
        if limit is not None and value is not None and value <= 0:
            yield error_at(
                place(limit),
                "no-power",
                name,
                f"joint '{short(name)}' has the {what} limit {value:g}, to which "
                "ros_control clamps every command: it will never move",
                f'give the motor\'s {what}="…", above zero',
            )


def value_findings(root: Element) -> Iterator[Finding]:
    """Yield the attributes of links and joints that are no numbers."""
    for kind in ("link", "joint"):
        for owner in children(root, kind):
            for element in descendants(owner):
                yield from _values(element, attribute(owner, "name"))


def _values(element: Element, owner: str) -> Iterator[Finding]:
    for name, count in _COUNTS.get(element.tagName, {}).items():
        if not element.hasAttribute(name):
            continue
        text = attribute(element, name)
        words = text.split()
        is_good = all(map(is_number, words))
        if is_good and len(words) == count:
            continue
        numbers = "a number" if count == 1 else f"{count} numbers"
        yield error_at(
            place(element),
            "not-a-number",
            owner,
            f'<{element.tagName} {name}="{short(text)}"> of '
            f"'{short(owner)}' is not {numbers} that a robot could have, so ROS "
            "refuses it, or takes it for another",
            _advice(text, numbers),
        )


def _advice(text: str, numbers: str) -> str:
    if "${" in text or "$(" in text:
        return "expand the file with xacro first: plain URDF has no expressions"
    if "," in text:
        return f"write {numbers}, with spaces and a decimal point, no comma"
    return f"write {numbers}, in m, rad, kg, N, as in 0.5"


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
