"""Which files a catkin workspace gets, and the folder that they go into."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Final

from tool0.description.packages import BUNDLED, crawl, package_name
from tool0.errors import ConfigError

PACKAGES: Final = ("tool0_description", "tool0_gazebo")
UPSTREAM_PACKAGES: Final = ("ur_description", "robotiq_2f_85_gripper_visualization")
"""Whose meshes can replace ours."""
SCRIPTS: Final = "scripts"
"""The folder of programs."""

_OWN_MESHES: Final = b'name="meshes" default="tool0"'
_UPSTREAM_MESHES: Final = b'name="meshes" default="upstream"'
_LAST_DEPENDENCY: Final = b"  <exec_depend>xacro</exec_depend>\n"


def package_files(*, upstream_meshes: bool = False) -> Mapping[PurePosixPath, bytes]:
    """Return the content of the files by their paths below ``src``.

    Args:
        upstream_meshes: Whether the meshes of ``UPSTREAM_PACKAGES`` are the default,
            and those packages are dependencies.
    """
    files = {
        PurePosixPath(path.relative_to(BUNDLED).as_posix()): path.read_bytes()
        for package in PACKAGES
        for path in sorted((BUNDLED / package).rglob("*"))
        if path.is_file() and not _is_by_product(path.relative_to(BUNDLED))
    }
    if upstream_meshes:
        files = {path: _with_upstream(path, data) for path, data in files.items()}
    return files


def _is_by_product(path: Path) -> bool:
    """Return whether tools left it, and it is no part of a package."""
    return any(name.startswith((".", "__pycache__")) for name in path.parts)


def _with_upstream(path: PurePosixPath, data: bytes) -> bytes:
    if path == PurePosixPath("tool0_description", "package.xml"):
        depends = "".join(
            f'  <exec_depend condition="$ROS_VERSION == 1">{name}</exec_depend>\n'
            for name in sorted(UPSTREAM_PACKAGES)
        )
        return data.replace(_LAST_DEPENDENCY, depends.encode() + _LAST_DEPENDENCY)
    return data.replace(_OWN_MESHES, _UPSTREAM_MESHES)


# --- the folder ---


def source_folder(folder: Path) -> Path:
    """Return the folder of packages that ``folder`` has, is, or will have.

    A workspace has ``src``; so will a folder that is empty, or does not exist yet.  A
    folder is one itself if it is called ``src``, has packages in it, or
    catkin_init_workspace was run there.

    Raises:
        ConfigError: If packages cannot be put there.
    """
    folder = folder.expanduser().absolute()
    _refuse_files(folder)
    _refuse_packages(folder)
    below = folder / "src"
    found = below if below.is_dir() or not _holds_packages(folder) else folder
    _refuse_files(found)
    _refuse_duplicates(found)
    return found


def _holds_packages(folder: Path) -> bool:
    if folder.name == "src":
        return True
    try:
        children = sorted(folder.iterdir())
    except OSError:
        return False
    # catkin's top-level CMakeLists.txt is a link to where catkin is installed
    has_toplevel = (folder / "CMakeLists.txt").is_symlink()
    return has_toplevel or any((child / "package.xml").is_file() for child in children)


def _refuse_files(folder: Path) -> None:
    for path in (folder, *folder.parents):
        if path.exists() and not path.is_dir():
            raise ConfigError(f"'{path}' is not a folder; name a catkin workspace")
        if path.is_symlink() and not path.exists():
            raise ConfigError(f"'{path}' is a dangling link; remove or correct it")


def _refuse_packages(folder: Path) -> None:
    for path in (folder, *folder.parents):
        if (path / "package.xml").is_file():
            raise ConfigError(
                f"'{path}' is a ROS package, and catkin finds none inside another; "
                "name the workspace, the folder above its 'src'"
            )


def _refuse_duplicates(source: Path) -> None:
    """Raise ConfigError if a package of ours exists already in another folder."""
    ours = {source / name for name in PACKAGES}
    for path in ours:
        if path.is_symlink():
            raise ConfigError(
                f"'{path}' is a link to '{path.resolve()}', which would be written to; "
                "remove it, or name another workspace"
            )
    for path in crawl(source):
        name = package_name(path)
        if name in PACKAGES and path not in ours:
            raise ConfigError(
                f"'{path}' is a package called {name} already, and catkin accepts only "
                "one of a name; remove it, or put a CATKIN_IGNORE file into it"
            )
