"""Which packages there are: those given, those that tool0 brings, those of ROS."""

from __future__ import annotations

import difflib
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
        self._names: dict[Path, str | None] = {}

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
        folder = file.parent
        if folder not in self._names:
            around = next(
                (f for f in (folder, *folder.parents) if (f / "package.xml").is_file()),
                None,
            )
            self._names[folder] = None if around is None else _name(around)
        return self._names[folder]


def packages_around(file: Path) -> dict[str, Path]:
    """Return the packages beside the one that ``file`` lies in, with it, by name.

    They are sought below the catkin workspace's ``src``, or else in the folder above
    the package.
    """
    folders = file.absolute().parents
    for folder in folders:
        if (folder / "package.xml").is_file():
            sources = [f for f in folder.parents if f.name == "src"]
            root = next(iter(sources), folder.parent)
            return {_name(f): f for f in islice(crawl(root), _MAX_PACKAGES)}
    return {}


def _name(folder: Path) -> str:
    try:
        return package_name(folder)
    except OSError:
        return folder.name
