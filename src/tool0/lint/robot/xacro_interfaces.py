"""Misspelt hardware interfaces in xacro, also where nothing uses them yet."""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.dom.minidom import Element

from tool0.description.attributes import text_of
from tool0.description.finding import Finding, error_at
from tool0.lint.robot.elements import attribute, descendants, place
from tool0.lint.robot.interfaces import is_interface, meant_interface
from tool0.lint.robot.names import short
from tool0.lint.robot.xacro_macros import parameters_of

_LIKE = re.compile(r"interf|hardware", re.IGNORECASE)


def interface_findings(root: Element) -> Iterator[Finding]:
    """Yield the misspelt interfaces that are written out in a xacro file."""
    for element in descendants(root):
        for name, text in _values(element):
            if "$" in text or not _LIKE.search(text) or is_interface(text):
                continue
            meant = meant_interface(text)
            if meant:
                yield _typo(element, name, text, meant)


def _values(element: Element) -> Iterator[tuple[str, str]]:
    """Yield what ``element`` gives values to, and the values."""
    tag = element.tagName
    if tag == "hardwareInterface":
        yield "", text_of(element)
    elif tag == "xacro:macro":
        for parameter in parameters_of(element):
            yield parameter.name, parameter.default or ""
    elif tag in {"xacro:arg", "xacro:property"}:
        for key in ("default", "value"):
            yield attribute(element, "name"), attribute(element, key)
    elif tag.startswith("xacro:"):
        for key, value in element.attributes.items():
            if key not in {"filename", "file", "name"}:
                yield key, value.strip()


def _typo(element: Element, name: str, text: str, meant: str) -> Finding:
    of = f" of '{short(name)}'" if name else ""
    kind = "default" if element.tagName in {"xacro:macro", "xacro:arg"} else "value"
    return error_at(
        place(element),
        "interface-typo",
        name or text,
        f"the {kind} '{short(text)}'{of} is no hardware interface: "
        "gazebo_ros_control stops at a joint that gets it, and no controller runs",
        f"write {meant}",
    )
