"""Which packages there are: those given, those that tool0 brings, those of ROS."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import final

from tool0.description.packages import (
    BUNDLED,
    crawl,
    find_package,
    package_name,
)
from tool0.errors import DescriptionError, nearest_name

_STANDARD = {"xacro": Path("/opt/ros/noetic/share/xacro")}
"""Found without ROS, too: tool0 does itself what this program is asked for."""
_MAX_DEPTH = 6
_MAX_FOLDERS = 5000
"""That are looked into for packages: a ``src`` may hold anything."""


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
        return nearest_name(name, self._known, cutoff=0.85)

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

    They are sought below each folder ``src`` that the package lies in, as in a catkin
    workspace, or else beside the package.
    """
    folders = file.absolute().parents
    package = next((folder for folder in folders if is_package(folder)), None)
    if package is None:
        return {}
    sources = [folder for folder in package.parents if folder.name == "src"]
    found: dict[str, Path] = {}
    for root in sources:  # the nearest first, and its packages count
        for folder in _below(root, depth=_MAX_DEPTH):
            found.setdefault(_name(folder), folder)
    for folder in () if sources else _below(package.parent, depth=1):
        found.setdefault(_name(folder), folder)
    found[_name(package)] = package
    return found


def _below(root: Path, depth: int) -> Iterator[Path]:
    """Yield the packages below ``root``: so many levels down, and not without end."""
    seen: set[str] = set()
    level = [root]
    for _ in range(depth):
        folders = [inner for folder in level for inner in _folders(folder)]
        level = []
        for folder in folders:
            real = os.path.realpath(folder)
            if real in seen or len(seen) > _MAX_FOLDERS:
                continue
            seen.add(real)
            if is_package(folder):
                yield folder  # packages do not nest
            else:
                level.append(folder)


def _folders(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            found = [e.name for e in entries if e.name[0] != "." and e.is_dir()]
    except OSError:
        return []
    return [folder / name for name in sorted(found)]


def _name(folder: Path) -> str:
    try:
        return package_name(folder)
    except OSError:
        return folder.name
