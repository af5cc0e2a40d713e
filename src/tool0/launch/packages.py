"""Which packages there are: those given, those that tool0 brings, those of ROS."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import final

from tool0.description.packages import (
    BUNDLED,
    crawl,
    find_package,
    package_name,
)
from tool0.errors import DescriptionError

_STANDARD = {"xacro": Path("/opt/ros/noetic/share/xacro")}
"""Found without ROS, too: tool0 does itself what this program is asked for."""
_MAX_PACKAGES = 1000
"""Of one workspace."""


@final
class Packages:
    """Finds packages by name, and remembers what it found."""

    def __init__(self, given: Mapping[str, Path] | None = None) -> None:
        """Prepare to look.

        Args:
            given: Name to folder of packages that come before all others, such as
                those of the workspace that is looked at.
        """
        self._found: dict[str, Path | DescriptionError] = dict(given or {})
        self._known = {*self._found, *(folder.name for folder in crawl(BUNDLED))}
        self._around: dict[Path, tuple[str, Path] | None] = {}

    @property
    def has_ros(self) -> bool:
        """Whether ROS is here; without it a package that is missing tells nothing."""
        try:
            self.find("roslaunch")
        except DescriptionError:
            return False
        return True

    def nearest(self, name: str) -> str | None:
        """Return the package given, or brought by tool0, that may have been meant."""
        near = difflib.get_close_matches(name, self._known, n=1, cutoff=0.85)
        return near[0] if near else None

    def find(self, name: str) -> Path:
        """Return the folder of a package.

        Raises:
            DescriptionError: If it is nowhere.
        """
        if name not in self._found:
            try:
                self._found[name] = find_package(name)
            except (DescriptionError, OSError, ValueError) as error:
                self._found[name] = _STANDARD.get(name, DescriptionError(str(error)))
        found = self._found[name]
        if isinstance(found, DescriptionError):
            raise found
        return found

    def package_of(self, file: Path) -> str | None:
        """Return the name of the package that a file lies in; None if in none."""
        around = self.around(file)
        return None if around is None else around[0]

    def around(self, file: Path) -> tuple[str, Path] | None:
        """Return name and folder of the package that a file lies in."""
        folder = file.parent
        if folder not in self._around:
            candidates = (folder, *folder.parents)
            found = next((f for f in candidates if is_package(f)), None)
            self._around[folder] = None if found is None else (_name(found), found)
        return self._around[folder]

    def folders(self) -> dict[str, Path]:
        """Return the packages that were found so far, by name."""
        folders = dict(p for p in self._around.values() if p is not None)
        found = {n: f for n, f in self._found.items() if isinstance(f, Path)}
        return {**folders, **found}


def is_package(folder: Path) -> bool:
    """Whether a folder is a package."""
    return os.path.isfile(folder / "package.xml")  # noqa: PTH113  # Path's may raise


def packages_around(file: Path) -> dict[str, Path]:
    """Return the packages beside the one that ``file`` lies in, with it, by name.

    They are sought below the catkin workspace's ``src``, or else in the folder above
    the package.
    """
    folders = file.absolute().parents
    for folder in folders:
        if is_package(folder):
            sources = [f for f in folder.parents if f.name == "src"]
            root = next(iter(sources), folder.parent)
            return {_name(f): f for f in islice(crawl(root), _MAX_PACKAGES)}
    return {}


def _name(folder: Path) -> str:
    try:
        return package_name(folder)
    except OSError:
        return folder.name
