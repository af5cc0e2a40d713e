"""Reading numbers and names from XML attributes, with errors that name the line."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from xml.dom.minidom import Element

from tool0.description.transform import Pose, Vector3
from tool0.description.xml_source import children, locate
from tool0.errors import DescriptionError, ModelError, SourceLocation, did_you_mean


def required(element: Element, attribute: str) -> str:
    """Return the text of ``attribute``, or raise DescriptionError."""
    if not element.hasAttribute(attribute):
        raise DescriptionError(
            f'<{element.tagName}> lacks the attribute {attribute}="…"', locate(element)
        )
    text = element.getAttribute(attribute).strip()
    if not text:
        raise DescriptionError(
            f'<{element.tagName} {attribute}=""> is empty; give it a value',
            locate(element),
        )
    return text


def only_child(element: Element, tag: str) -> Element | None:
    """Return the one child called ``tag``; None if there is none."""
    found = list(children(element, tag))
    if len(found) > 1:
        raise DescriptionError(
            f"<{element.tagName}> has {len(found)} <{tag}>; leave one", locate(found[1])
        )
    return found[0] if found else None


def required_child(element: Element, tag: str) -> Element:
    """Return the one child called ``tag``, or raise DescriptionError."""
    child = only_child(element, tag)
    if child is None:
        name = element.getAttribute("name")
        of = f" of '{name}'" if name else ""
        raise DescriptionError(
            f"<{element.tagName}>{of} lacks <{tag}>", locate(element)
        )
    return child


def number(element: Element, attribute: str, default: float | None = None) -> float:
    """Return ``attribute`` as a number; without ``default`` it must be there."""
    if default is not None and not element.hasAttribute(attribute):
        return default
    return to_number(required(element, attribute), element, attribute)


def to_number(text: str, element: Element, what: str) -> float:
    """Return ``text``, found in ``element``, as a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise DescriptionError(
            f"<{element.tagName}>: {what} '{text}' is not a finite number",
            locate(element),
        )
    return value


def numbers(
    element: Element, attribute: str, count: int, default: Sequence[float] | None = None
) -> tuple[float, ...]:
    """Return ``count`` numbers from ``attribute``, separated by spaces."""
    if default is not None and not element.hasAttribute(attribute):
        return tuple(default)
    return to_numbers(required(element, attribute), count, element, attribute)


def to_numbers(text: str, count: int, element: Element, what: str) -> tuple[float, ...]:
    """Return ``count`` numbers from ``text``, found in ``element``."""
    words = text.split()
    if len(words) != count:
        raise DescriptionError(
            f"<{element.tagName}>: {what} '{text}' has {len(words)} numbers; "
            f"give {count}, separated by spaces",
            locate(element),
        )
    return tuple(to_number(word, element, what) for word in words)


def vector(
    element: Element, attribute: str, default: Sequence[float] | None = None
) -> Vector3:
    """Return three numbers from ``attribute``."""
    x, y, z = numbers(element, attribute, 3, default)
    return (x, y, z)


def origin(element: Element) -> Pose:
    """Return ``<origin>`` of ``element``; none means the identity."""
    child = only_child(element, "origin")
    if child is None:
        return Pose()
    zero = (0.0, 0.0, 0.0)
    return Pose(xyz=vector(child, "xyz", zero), rpy=vector(child, "rpy", zero))


def not_negative(value: float, what: str, element: Element) -> float:
    """Return ``value``, or raise ModelError; ``what`` comes before it."""
    if not value >= 0:
        raise ModelError(f"{what} {value:g}; it must not be negative", locate(element))
    return value


def positive(element: Element, attribute: str) -> float:
    """Return ``attribute`` as a number above zero."""
    value = number(element, attribute)
    if not value > 0:
        raise DescriptionError(
            f'<{element.tagName} {attribute}="{value:g}">: must be above zero',
            locate(element),
        )
    return value


def choice(text: str, valid: Sequence[str], element: Element, what: str) -> str:
    """Return ``text`` if it is one of ``valid``, or raise DescriptionError."""
    if text not in valid:
        hint = did_you_mean(text, list(valid))
        raise DescriptionError(f"unknown {what} '{text}'{hint}", locate(element))
    return text


def require_known(
    name: str, valid: Collection[str], what: str, location: SourceLocation | None
) -> None:
    """Raise ModelError unless ``name`` is one of ``valid``; ``what`` comes first."""
    if name not in valid:
        raise ModelError(f"{what} '{name}'{did_you_mean(name, list(valid))}", location)


def text_of(element: Element) -> str:
    """Return the text inside ``element``, stripped."""
    parts = (
        node.nodeValue or ""
        for node in element.childNodes
        if node.nodeType in {node.TEXT_NODE, node.CDATA_SECTION_NODE}
    )
    return "".join(parts).strip()


def child_number(element: Element, tag: str) -> float | None:
    """Return the number inside the child ``tag``; None if there is no such child."""
    child = only_child(element, tag)
    return None if child is None else to_number(text_of(child), child, tag)
