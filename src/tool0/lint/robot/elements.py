"""Reads XML that may be faulty.  Unreadable values are None or empty."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import final
from xml.dom.minidom import Element

from tool0.description.finding import Finding, Severity
from tool0.description.xml_source import children, locate, text_of
from tool0.errors import SourceLocation, nearest_name

HUGE = 1e12
"""Largest absolute value of a number that is accepted in a robot.  The cube of a larger
number might overflow."""


@final
@dataclass(frozen=True, slots=True)
class Subject:
    """Subject of findings, and the subject's location."""

    key: str
    location: SourceLocation

    def error(
        self,
        rule: str,
        message: str,
        remedy: str = "",
        *,
        key: str | None = None,
        severity: Severity = "error",
    ) -> Finding:
        """Return an error about this subject.  ``key`` replaces the subject's key."""
        return Finding(
            location=self.location,
            rule=rule,
            severity=severity,
            key=self.key if key is None else key,
            message=message,
            remedy=remedy,
        )

    def warning(
        self, rule: str, message: str, remedy: str = "", *, key: str | None = None
    ) -> Finding:
        """Return a warning about this subject.  ``key`` replaces the subject's key."""
        return self.error(rule, message, remedy, key=key, severity="warning")


@final
@dataclass(frozen=True, slots=True)
class Tag:
    """An XML element.  An absent element is false, and all of its parts are empty."""

    element: Element | None
    owner: str = ""
    """Name of the enclosing link, joint or transmission, which is the subject of
    findings."""

    def __bool__(self) -> bool:
        return self.element is not None

    def __getitem__(self, attribute: str) -> str:
        """Attribute without surrounding whitespace; empty if it is missing."""
        return self.written(attribute).strip()

    def __contains__(self, attribute: str) -> bool:
        return self.element is not None and self.element.hasAttribute(attribute)

    def written(self, attribute: str) -> str:
        """Return the attribute as it is written in the file; empty if it is missing."""
        return "" if self.element is None else self.element.getAttribute(attribute)

    @property
    def tag(self) -> str:
        """Tag name of the element."""
        return "" if self.element is None else self.element.tagName

    @property
    def text(self) -> str:
        """Text inside the element."""
        return "" if self.element is None else text_of(self.element)

    @property
    def attributes(self) -> list[tuple[str, str]]:
        """All attributes as they are written in the file."""
        return [] if self.element is None else list(self.element.attributes.items())

    @property
    def location(self) -> SourceLocation:
        """Location of the element, without a file if the file is unknown."""
        return locate(self.element) or SourceLocation(None)

    @property
    def at(self) -> Subject:
        """Owner of the element as a subject, at the location of this element."""
        return Subject(self.owner, self.location)

    def children(self, tag: str | None = None) -> Iterator[Tag]:
        """Yield all child elements, or only child elements named ``tag``."""
        for element in () if self.element is None else children(self.element, tag):
            yield Tag(element, self.owner or element.getAttribute("name").strip())

    def child(self, tag: str) -> Tag:
        """Return the first child named ``tag``, which is the one that urdfdom reads."""
        return next(self.children(tag), Tag(None))

    def descendants(self, tag: str | None = None) -> Iterator[Tag]:
        """Yield the element and its descendants in order, or only ``tag`` elements."""
        waiting = [self]
        while waiting:
            found = waiting.pop()
            if tag is None or found.tag == tag:
                yield found
            waiting.extend(reversed(list(found.children())))

    def number(self, attribute: str, default: float | None = None) -> float | None:
        """Return the attribute as a number; None if it is not a number.

        Args:
            attribute: Name of the attribute.
            default: The value to return if the attribute is missing or empty.
        """
        text = self[attribute]
        return _to_number(text) if text else default

    def vector(self, attribute: str) -> tuple[float, ...] | None:
        """Return the attribute as three numbers; None if this is not possible."""
        values = [_to_number(word) for word in self[attribute].split()]
        found = tuple(value for value in values if value is not None)
        return found if len(values) == len(found) == 3 else None


def _to_number(text: str) -> float | None:
    """Return ``text`` as a finite, plausible number; None if this is not possible."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if abs(value) <= HUGE else None  # the comparison is false for NaN


def length(values: tuple[float, ...]) -> float:
    """Return the Euclidean length of ``values``."""
    return math.sqrt(sum(value * value for value in values))


def suggestion(name: str, known: Collection[str], write: str, otherwise: str) -> str:
    """Return ``write`` with the most similar name in place of ``{}``.

    Return ``otherwise`` if no name is similar.
    """
    close = nearest_name(name, known)
    return write.replace("{}", close) if close else otherwise
