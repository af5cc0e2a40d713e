"""Finding packages and files for a rule: once each, and without an exception."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import final

from tool0.description.finding import Finding
from tool0.description.packages import find_package
from tool0.errors import DescriptionError, SourceLocation, nearest_name
from tool0.lint.robot.elements import short

_NAME = re.compile(r"[A-Za-z][\w-]{0,99}")
_MOST_FILES = 500
_MOST_SOUGHT = 50
"""Each package that is nowhere costs a walk through ROS_PACKAGE_PATH."""


@final
class Packages:
    """The packages that one file names; each is sought once."""

    def __init__(self, known: Mapping[str, Path]) -> None:
        self._known = known
        self._found: dict[str, Path | None] = {}

    def find(self, name: str) -> Path | None:
        """Return the folder of the package ``name``, or None."""
        if name in self._known:
            return self._known[name]
        if name not in self._found:
            self._found[name] = self._seek(name)
        return self._found[name]

    def _seek(self, name: str) -> Path | None:
        if not _NAME.fullmatch(name) or len(self._found) > _MOST_SOUGHT:
            return None
        try:
            return find_package(name)
        except (DescriptionError, OSError):
            return None

    def unknown(self, name: str, user: str, location: SourceLocation) -> Finding:
        """Return that ``user`` needs a package that is nowhere to be seen."""
        close = nearest_name(name, self._known, cutoff=0.85)
        is_name = _NAME.fullmatch(name) is not None
        return Finding(
            location=location,
            rule="unknown-package",
            severity="error" if close or not is_name else "warning",
            key=name,
            message=(
                f"{user} needs the package '{short(name)}', which is neither here nor "
                "in ROS_PACKAGE_PATH"
                if is_name
                else f"{user} names no package, and '{short(name)}' can be none"
            ),
            remedy=(
                f"write {close}"
                if close
                else "write package://PACKAGE/PATH or $(find PACKAGE)"
                if not is_name
                else "install it, or put it into the workspace and source its "
                "setup.bash"
            ),
        )


def nearest_file(path: Path) -> str | None:
    """Return the name most like that of ``path`` in its folder, or None."""
    try:
        with os.scandir(path.parent) as entries:
            names = [entry.name for _, entry in zip(range(_MOST_FILES), entries)]  # noqa: B905  # stops at the shorter
    except (OSError, ValueError):
        return None
    same = [name for name in names if name.lower() == path.name.lower()]
    return same[0] if same else nearest_name(path.name, names, cutoff=0.7)
