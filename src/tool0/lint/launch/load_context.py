"""State that is shared by all files of one run, such as limits and node names."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Final, final
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at
from tool0.description.xml_source import parse_text
from tool0.errors import DescriptionError, SourceLocation
from tool0.lint.packages import PackageIndex

MAX_NESTING: Final = 40
"""Largest depth of nested groups and includes."""
MAX_FILES: Final = 500
MAX_ELEMENTS: Final = 20_000
MAX_CHARACTERS: Final = 5_000_000
"""Largest total size of all texts after substitution [characters]."""
MAX_BYTES: Final = 1_000_000
"""Largest size of one file [bytes]."""

_START: Final = re.compile(r"<(?:[^<>'\"]|'[^']*'|\"[^\"]*\")*>")
"""A start tag.  Quoted values in the tag may contain any bracket."""


@final
class LoadContext:
    """State kept while a launch file and all files that it includes are read."""

    def __init__(self, packages: PackageIndex) -> None:
        self.packages = packages
        self.nodes: dict[str, SourceLocation] = {}
        """Full names of nodes that are certainly active, with the nodes' locations."""
        self.depth = 0
        self._open: list[object] = []
        self._left = {
            "files": MAX_FILES,
            "elements": MAX_ELEMENTS,
            "characters": MAX_CHARACTERS,
        }
        self._roots: dict[Path, Element | Finding] = {}
        self._lines: dict[Path, list[str]] = {}
        self._anonymous = 0

    def spend(self, what: str, count: int = 1) -> bool:
        """Add ``count`` to a counter; return False if the limit is exceeded."""
        self._left[what] -= count
        return self._left[what] >= 0

    def anonymous(self, name: str) -> str:
        """Return a unique name. roslaunch derives a name from host and time."""
        self._anonymous += 1
        return f"{name}_anonymous_{self._anonymous}"

    def enter(self, reading: object) -> bool:
        """Start to read a file with its arguments.

        The result is False if the file is already being read with these arguments.
        """
        if reading in self._open:
            return False
        self._open.append(reading)
        return True

    def leave(self) -> None:
        """Finish reading the file whose reading was started last."""
        self._open.pop()

    def text_line(self, path: Path, element: Element) -> int | None:
        """Return the line on which an element's text begins."""
        line: int | None = getattr(getattr(element, "location", None), "line", None)
        if line is None:
            return None
        if path not in self._lines:
            text = path.read_text(encoding="utf-8", errors="replace")
            self._lines[path] = text.split("\n")
        rest = "\n".join(self._lines[path][line - 1 : line + 20])
        tag = _START.search(rest, max(rest.find(f"<{element.tagName}"), 0))
        return line if tag is None else line + rest.count("\n", 0, tag.end())

    def root(self, path: Path) -> Element | Finding:
        """Return the file's ``<launch>`` element, or a finding if there is none."""
        if path not in self._roots:
            self._roots[path] = _root(path)
        return self._roots[path]


def is_file(path: str | Path) -> bool:
    """Return whether a path is a file.  The result for an invalid path is False."""
    return os.path.isfile(path)  # noqa: PTH113  # Path's raises if a name is too long


def read_limited(path: Path) -> bytes:
    """Return the content of a file.

    Raises:
        DescriptionError: If the path is not a file, if the file cannot be read, or if
            it is too large.
    """
    if not is_file(path):
        raise DescriptionError("is no file")
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise DescriptionError(f"is {size} bytes long; the maximum is {MAX_BYTES}")
        return path.read_bytes()
    except OSError as error:
        raise DescriptionError(f"cannot be read: {error.strerror}") from None


def parse_limited(path: Path) -> Element | None:
    """Return the outermost element of an XML file.

    Raises:
        DescriptionError: If the file cannot be read, decoded or parsed.
    """
    try:
        return parse_text(read_limited(path), path).documentElement
    # LookupError is raised for an unknown encoding
    except (LookupError, ValueError) as error:
        raise DescriptionError(f"cannot be decoded: {error}") from None


def _root(path: Path) -> Element | Finding:
    where = SourceLocation(path)
    try:
        root = parse_limited(path)
    except DescriptionError as error:
        return error_at(error.location or where, "not-xml", path.name, error.message)
    if root is not None and root.tagName == "launch":
        return root
    tag = "nothing" if root is None else f"<{root.tagName}>"
    return error_at(
        where,
        "not-launch",
        path.name,
        f"is no launch file: its root is {tag} instead of <launch>",
        "put all of it into <launch>…</launch>",
    )
