"""Finds ROS packages: given packages, packages of tool0, and packages of ROS."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TypeAlias, final

from tool0.description.finding import Finding, error_at, short, warning_at
from tool0.description.packages import (
    BUNDLED,
    crawl,
    find_package,
    is_package,
    name_of_package,
)
from tool0.errors import DescriptionError, SourceLocation, is_typo, nearest_name

_STANDARD = {"xacro": Path("/opt/ros/noetic/share/xacro")}
"""Packages that are accepted without ROS, because tool0 implements their programs."""
_NAME = re.compile(r"[A-Za-z][\w-]{0,99}")
_MAX_FILES = 500
_MAX_SEARCHES = 200
"""Largest number of missing packages that are searched for.  Each search goes through
ROS_PACKAGE_PATH."""


Packages: TypeAlias = Mapping[str, Path]
"""Folders of the packages that take precedence, such as packages of the workspace, by
name."""


@cache
def _bundled_names() -> frozenset[str]:
    return frozenset(folder.name for folder in crawl(BUNDLED))


@final
class PackageIndex:
    """Finds packages by name.  Each package is searched for only once."""

    def __init__(self, given: Packages | None = None) -> None:
        self._given = dict(given or {})
        self._found: dict[str, Path | DescriptionError] = dict(self._given)
        self._around: dict[Path, tuple[str, Path] | None] = {}

    @property
    def has_ros(self) -> bool:
        """Whether ROS is installed.  Without ROS, a missing package is not a fault."""
        return self.get("roslaunch") is not None

    def get(self, name: str) -> Path | None:
        """Return the folder of a package; None if the package is not found."""
        found = self._search(name)
        return found if isinstance(found, Path) else None

    def find(self, name: str) -> Path:
        """Return the folder of a package, or the folder in which ROS installs it.

        Raises:
            DescriptionError: If the package is not found.
        """
        found = self._search(name)
        if isinstance(found, Path):
            return found
        if name in _STANDARD:
            return _STANDARD[name]
        raise found

    def _search(self, name: str) -> Path | DescriptionError:
        if name not in self._found:
            if not _NAME.fullmatch(name) or len(self._found) > _MAX_SEARCHES:
                return DescriptionError(f"there is no ROS package '{short(name)}'")
            try:
                self._found[name] = find_package(name)
            except (DescriptionError, OSError, ValueError) as error:
                self._found[name] = DescriptionError(str(error))
        return self._found[name]

    def nearest(self, name: str) -> str | None:
        """Return a given or bundled package whose name may be misspelled, if any."""
        near = nearest_name(name, _bundled_names().union(self._given), cutoff=0.85)
        # ur_description is not a misspelling of pr2_description
        is_meant = is_typo(name, near) and near is not None and near[0] == name[0]
        return near if is_meant else None

    def unknown(self, name: str, user: str, location: SourceLocation) -> Finding:
        """Return a finding that reports that ``user`` needs a missing package."""
        near = self.nearest(name)
        is_name = _NAME.fullmatch(name) is not None
        message = f"{user} names no package: '{short(name)}' is not a valid name"
        remedy = "write package://PACKAGE/PATH or $(find PACKAGE)"
        if is_name:
            message = (
                f"{user} needs the package '{short(name)}', which is neither here nor "
                "in ROS_PACKAGE_PATH"
            )
            remedy = (
                "install it, or put it into the workspace and source its setup.bash"
            )
        finding_at = error_at if near or not is_name else warning_at
        return finding_at(
            location,
            "unknown-package",
            name,
            message,
            f"did you mean '{near}'?" if near else remedy,
        )

    def package_of(self, file: Path) -> str | None:
        """Return the package name of a file; None if the file is in no package."""
        around = self.around(file)
        return None if around is None else around[0]

    def around(self, file: Path) -> tuple[str, Path] | None:
        """Return the name and folder of the package that contains a file, or None."""
        folder = file.parent
        if folder not in self._around:
            candidates = (folder, *folder.parents)
            found = next((f for f in candidates if is_package(f)), None)
            self._around[folder] = (
                None if found is None else (name_of_package(found), found)
            )
        return self._around[folder]

    def folders(self) -> dict[str, Path]:
        """Return the folders of all packages that have been found, by name."""
        folders = dict(p for p in self._around.values() if p is not None)
        found = {n: f for n, f in self._found.items() if isinstance(f, Path)}
        return {**folders, **found}


def nearest_file(path: Path) -> str | None:
    """Return the file name in the folder of ``path`` that is most similar, or None."""
    try:
        with os.scandir(path.parent) as entries:
            names = [entry.name for _, entry in zip(range(_MAX_FILES), entries)]  # noqa: B905  # stops at the shorter
    except (OSError, ValueError):
        return None
    same = [name for name in names if name.lower() == path.name.lower()]
    return same[0] if same else nearest_name(path.name, names, cutoff=0.7)
