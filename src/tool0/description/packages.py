"""Search for ROS packages and for files in the packages, without ROS.

The search has three steps.  Bundled packages are searched first.  Then the entries of
``ROS_PACKAGE_PATH`` are searched; an entry is a package or a folder that contains
packages.  Finally, the packages that ROS 2 has installed below the entries of
``AMENT_PREFIX_PATH`` are searched.  ``preferring`` gives other packages precedence over
all of these packages, for example the packages of a file's workspace, which
``packages_around`` returns.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import MappingProxyType

from tool0.description.finding import quoted
from tool0.errors import DescriptionError, SourceLocation, did_you_mean
from tool0.user_data import expanded

BUNDLED = Path(__file__).resolve().parent.parent / "ros_packages"

_NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
_NONE: Mapping[str, Path] = MappingProxyType({})
_PREFERRED: ContextVar[Mapping[str, Path]] = ContextVar("preferred", default=_NONE)
_MAX_FOLDERS = 100
_MAX_DEPTH = 6
_MAX_WALKED = 5000
"""Largest number of folders that are searched for packages.  The number is limited,
since a folder ``src`` can contain arbitrarily many folders."""
_IGNORE = ("CATKIN_IGNORE", "COLCON_IGNORE", "AMENT_IGNORE")


def find_package(name: str, location: SourceLocation | None = None) -> Path:
    """Return the folder of the ROS package ``name``.

    Raises:
        DescriptionError: If the package is not found.  The message lists the search
            path.
    """
    if name in _PREFERRED.get():
        return _PREFERRED.get()[name]
    bundled = BUNDLED / name
    if (bundled / "package.xml").is_file():
        return bundled
    seen = {path.name for path in crawl(BUNDLED)} | set(_PREFERRED.get())
    search_path = [
        path
        for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
        if entry and (path := expanded(entry)).is_dir()
    ]
    for entry in search_path:
        for folder in crawl(entry):
            if package_name(folder) == name:
                return folder
            seen.add(package_name(folder))
    installed = list(_share_folders())
    for share in installed:
        if (share / name / "package.xml").is_file():
            return share / name
    seen.update(path.name for share in installed for path in share.iterdir())
    around = (
        [f"the workspace ({quoted(sorted(_PREFERRED.get()))})"]
        if _PREFERRED.get()
        else []
    )
    looked = ", ".join([*around, *map(str, (BUNDLED, *search_path, *installed))])
    raise DescriptionError(
        f"there is no ROS package '{name}' in {looked}{did_you_mean(name, seen)}; put "
        "it into the workspace, or add its parent folder to ROS_PACKAGE_PATH",
        location,
    )


def _share_folders() -> Iterator[Path]:
    """Yield ROS 2's ``share`` folders, which contain one folder per package."""
    for entry in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if entry and (share := expanded(entry) / "share").is_dir():
            yield share


@contextmanager
def preferring(packages: Mapping[str, Path]) -> Iterator[None]:
    """Give ``packages`` precedence over all other packages within the context."""
    before = _PREFERRED.set(packages)
    try:
        yield
    finally:
        _PREFERRED.reset(before)


def resolve_uri(uri: str, location: SourceLocation | None = None) -> Path:
    """Return the path for a URI ``package://…`` or ``file://…``, or a plain path.

    A relative path is relative to the file that contains it.  The caller checks
    whether the file exists.
    """
    scheme, separator, rest = uri.partition("://")
    if not separator:
        path = expanded(uri)
        if path.is_absolute() or location is None or location.file is None:
            return path
        return location.file.parent / path
    if scheme == "package":
        package, _, inside = rest.partition("/")
        return find_package(package, location) / inside
    if scheme == "file":
        return Path("/" + rest.lstrip("/"))
    raise DescriptionError(
        f"'{scheme}://' in '{uri}' is not supported; "
        "write package://PACKAGE/PATH, file:///PATH or a path",
        location,
    )


def source_path(path: Path) -> Path:
    """Return the source path of a file in a package's share folder.

    CMake can install folders under other paths: ``description/urdf`` can become
    ``share/PACKAGE/urdf``.  If the path exists, it is returned unchanged.  The path is
    also returned unchanged unless exactly one of the package's folders contains a
    matching file.
    """
    if os.path.lexists(path):
        return path
    parents = (f for f in path.parents if os.path.isfile(f / "package.xml"))  # noqa: PTH113  # Path's may raise
    package = next(parents, None)
    if package is None:
        return path
    inside = path.relative_to(package)
    first = _folders(package)
    folders = [*first, *(q for p in first[:_MAX_FOLDERS] for q in _folders(p))]
    found = [folder / inside for folder in folders if (folder / inside).exists()]
    return found[0] if len(found) == 1 else path


def _folders(folder: Path) -> list[Path]:
    return [path for path in sorted(folder.iterdir()) if path.is_dir()]


def crawl(root: Path) -> Iterator[Path]:
    """Yield the package folders at or below ``root``, parents before children."""
    for folder, children, files in os.walk(root, followlinks=True):
        if any(mark in files for mark in _IGNORE):
            children.clear()
        elif "package.xml" in files:
            children.clear()  # packages do not nest
            yield Path(folder)
        else:
            children[:] = sorted(name for name in children if name[0] != ".")


def package_name(folder: Path) -> str:
    """Return the name in the manifest of the package in ``folder``."""
    text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    match = _NAME.search(text)
    return match.group(1) if match else folder.name


def packages_around(file: Path) -> dict[str, Path]:
    """Return the package that contains ``file``, and neighboring packages, by name.

    The search covers every folder ``src`` above the package, such as that of a catkin
    workspace.  If there is no folder ``src``, the search covers the siblings of the
    package.
    """
    folders = file.absolute().parents
    package = next((folder for folder in folders if is_package(folder)), None)
    if package is None:
        return {}
    sources = [folder for folder in package.parents if folder.name == "src"]
    found: dict[str, Path] = {}
    for root in sources:  # the nearest folder is first and takes precedence
        for folder in _below(root, depth=_MAX_DEPTH):
            found.setdefault(name_of_package(folder), folder)
    for folder in () if sources else _below(package.parent, depth=1):
        found.setdefault(name_of_package(folder), folder)
    found[name_of_package(package)] = package
    return found


def is_package(folder: Path) -> bool:
    """Return whether a folder is a ROS package."""
    return os.path.isfile(folder / "package.xml")  # noqa: PTH113  # Path's may raise


def _below(root: Path, depth: int) -> Iterator[Path]:
    """Yield the packages at most ``depth`` levels below ``root``."""
    seen: set[str] = set()
    for name, folders, files in os.walk(root, followlinks=True):
        folder, real = Path(name), os.path.realpath(name)
        level = len(folder.parts) - len(root.parts)
        is_new = real not in seen and len(seen) <= _MAX_WALKED
        is_package = level > 0 and "package.xml" in files
        seen.add(real)
        if is_new and is_package:
            yield folder
        is_end = is_package or level >= depth or not is_new  # packages do not nest
        names = sorted(name for name in folders if name[0] != ".")
        folders[:] = [] if is_end else names


def name_of_package(folder: Path) -> str:
    """Return the name in the manifest, or the folder's name if there is no name."""
    try:
        return package_name(folder)
    except OSError:
        return folder.name
