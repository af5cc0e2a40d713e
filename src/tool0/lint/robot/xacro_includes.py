"""Files that a xacro file includes and that are not there."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at
from tool0.lint.robot.elements import attribute, descendants, place
from tool0.lint.robot.names import short
from tool0.lint.robot.packages import Packages, nearest_file

_FIND = re.compile(r"\$\(find\s+([^\s)]+)\s*\)")
_TRUE = ("true", "1")
_PATTERN = re.compile(r"[*?\[]")
"""xacro includes every file that matches, or none."""


def include_findings(root: Element, known: Mapping[str, Path]) -> Iterator[Finding]:
    """Yield the includes of files that do not exist."""
    packages = Packages(known)
    named: set[str] = set()
    for element in descendants(root):
        if element.tagName != "xacro:include":
            continue
        text = attribute(element, "filename")
        missing = [name for name in _FIND.findall(text) if packages.find(name) is None]
        for name in missing:
            if name not in named:
                named.add(name)
                yield packages.unknown(name, "an <xacro:include>", place(element))
        if not missing and attribute(element, "optional").lower() not in _TRUE:
            yield from _missing(element, text, packages)


def included_files(root: Element, known: Mapping[str, Path]) -> Iterator[Path]:
    """Yield the files that a xacro file includes, whatever its arguments are."""
    packages = Packages(known)
    for element in descendants(root):
        if element.tagName == "xacro:include":
            path = _included(element, attribute(element, "filename"), packages)
            if path is not None:
                yield path


def _included(element: Element, text: str, packages: Packages) -> Path | None:
    """Return the file that an include is about, if it is always the same."""
    location = place(element)
    folder = Path() if location.file is None else location.file.parent
    filled = _FIND.sub(lambda match: str(packages.find(match.group(1))), text)
    filled = filled.replace("$(dirname)", str(folder))
    if "$" in filled or _PATTERN.search(text):
        return None
    return folder / filled  # an absolute one stays as it is


def _missing(element: Element, text: str, packages: Packages) -> Iterator[Finding]:
    location, path = place(element), _included(element, text, packages)
    if path is None:
        return
    if text and os.path.isfile(path):  # noqa: PTH113  # Path.is_file may raise
        return
    close = nearest_file(path)
    yield error_at(
        location,
        "missing-include",
        text,
        f"there is no file '{short(str(path))}' to include, so xacro fails, and "
        "robot_description stays empty",
        f"there is '{close}'; write that" if close else "check the path",
    )
