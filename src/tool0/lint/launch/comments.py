"""Elements that somebody commented out: what was meant, and is not done."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from xml.dom.minidom import Element
from xml.parsers import expat

from tool0.description.xml_source import LocatedElement, children, parse_text
from tool0.errors import DescriptionError, SourceLocation
from tool0.lint.launch.session import read_bounded

_PREFIX = '<comment xmlns:xacro="http://www.ros.org/wiki/xacro">'


def commented_elements(file: Path) -> list[tuple[SourceLocation, Element]]:
    """Return the elements in an XML file's comments, with where they are written.

    A comment that is not well-formed, as prose with brackets in it, holds none; nor
    does a file that cannot be read.  Of elements in one another the outermost counts.
    """
    try:
        text = read_bounded(file)
    except DescriptionError:
        return []
    found = []
    for line, comment in _comments(text):
        if "<" not in comment:
            continue
        try:
            root = parse_text(f"{_PREFIX}{comment}</comment>", file).documentElement
        except (DescriptionError, ValueError):
            continue
        if root is not None:
            _move(root, line - 1)
            found += [(_place(element), element) for element in children(root)]
    return found


def _comments(text: bytes) -> list[tuple[int, str]]:
    """Return the comments, each with its first line, up to where XML ends to be so."""
    found: list[tuple[int, str]] = []
    parser = expat.ParserCreate()
    parser.CommentHandler = lambda data: found.append((parser.CurrentLineNumber, data))
    with suppress(expat.ExpatError, LookupError, ValueError):
        parser.Parse(text, True)  # what came before a mistake counts
    return found


def _move(root: Element, lines: int) -> None:
    """Add ``lines`` to the place of every element."""
    for element in _all(root):
        if element.location is not None and element.location.line is not None:
            element.location = SourceLocation(
                element.location.file, element.location.line + lines
            )


def _all(root: Element) -> Iterator[LocatedElement]:
    waiting = [root]
    while waiting:
        element = waiting.pop()
        waiting += children(element)
        if isinstance(element, LocatedElement):
            yield element


def _place(element: Element) -> SourceLocation:
    place: SourceLocation | None = getattr(element, "location", None)
    return place or SourceLocation(None)
