"""Attributes of a robot that should be numbers and are not."""

from __future__ import annotations

from collections.abc import Iterator
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at
from tool0.description.xml_source import children
from tool0.lint.robot.elements import attribute, descendants, is_number, place
from tool0.lint.robot.names import short

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
