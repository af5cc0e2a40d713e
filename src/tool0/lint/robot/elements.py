"""Reading XML that may be wrong: what cannot be read is None or empty, never raised."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.dom.minidom import Element

from tool0.description.xml_source import children, locate, text_of
from tool0.errors import SourceLocation

HUGE = 1e12
"""A number above it is no measure of a robot, and its cube might overflow."""


def place(element: Element) -> SourceLocation:
    """Return where ``element`` was written; without a file if that is unknown."""
    return locate(element) or SourceLocation(None)


def attribute(element: Element | None, name: str) -> str:
    """Return the stripped attribute; empty if it, or the element, is not there."""
    return "" if element is None else element.getAttribute(name).strip()


def child(element: Element | None, tag: str) -> Element | None:
    """Return the first child called ``tag``, as urdfdom takes it."""
    return None if element is None else next(children(element, tag), None)


def child_text(element: Element, tag: str) -> str:
    """Return the text in the first child called ``tag``; empty if there is none."""
    found = child(element, tag)
    return "" if found is None else text_of(found)


def to_number(text: str) -> float | None:
    """Return a finite number of a sane size, or None."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if abs(value) <= HUGE else None  # not so for NaN


def is_number(text: str) -> bool:
    """Return whether ROS reads ``text`` as a finite number, however large."""
    try:
        return math.isfinite(float(text)) and "_" not in text
    except ValueError:
        return False


def number(element: Element | None, name: str) -> float | None:
    """Return the attribute as a number; None if it is not there or is none."""
    return to_number(attribute(element, name))


def vector(
    element: Element | None, name: str, count: int = 3
) -> tuple[float, ...] | None:
    """Return ``count`` numbers from the attribute, or None."""
    values = [to_number(word) for word in attribute(element, name).split()]
    found = tuple(value for value in values if value is not None)
    return found if len(values) == len(found) == count else None


def length(values: tuple[float, ...]) -> float:
    """Return the Euclidean length of ``values``."""
    return math.sqrt(sum(value * value for value in values))


def descendants(element: Element) -> Iterator[Element]:
    """Yield ``element`` and all below it, in the order of the document."""
    waiting = [element]
    while waiting:
        found = waiting.pop()
        yield found
        waiting.extend(reversed(list(children(found))))
