"""What goes into a workspace: the packages that tool0 brings, file by file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Final

from tool0.description.packages import BUNDLED

PACKAGES: Final = ("tool0_description", "tool0_gazebo")
UPSTREAM_PACKAGES: Final = ("ur_description", "robotiq_2f_85_gripper_visualization")
"""Whose meshes stand in for ours."""
SCRIPTS: Final = "scripts"
"""The folder of programs."""

_OWN_MESHES: Final = b'name="meshes" default="tool0"'
_UPSTREAM_MESHES: Final = b'name="meshes" default="upstream"'
_LAST_DEPENDENCY: Final = b"  <exec_depend>xacro</exec_depend>\n"


def contents(*, upstream_meshes: bool = False) -> Mapping[PurePosixPath, bytes]:
    """Return the files by their paths below ``src``.

    Args:
        upstream_meshes: Whether the robot looks as in ``UPSTREAM_PACKAGES`` unless it
            is told otherwise, and depends on them.
    """
    files = {
        PurePosixPath(path.relative_to(BUNDLED).as_posix()): path.read_bytes()
        for package in PACKAGES
        for path in sorted((BUNDLED / package).rglob("*"))
        if path.is_file() and not _is_left_behind(path.relative_to(BUNDLED))
    }
    if upstream_meshes:
        files = {path: _with_upstream(path, data) for path, data in files.items()}
    return files


def _is_left_behind(path: Path) -> bool:
    """Return whether it is what tools leave, and no part of a package."""
    return any(name.startswith((".", "__pycache__")) for name in path.parts)


def _with_upstream(path: PurePosixPath, data: bytes) -> bytes:
    if path == PurePosixPath("tool0_description", "package.xml"):
        named = "".join(
            f'  <exec_depend condition="$ROS_VERSION == 1">{name}</exec_depend>\n'
            for name in sorted(UPSTREAM_PACKAGES)
        )
        return data.replace(_LAST_DEPENDENCY, named.encode() + _LAST_DEPENDENCY)
    return data.replace(_OWN_MESHES, _UPSTREAM_MESHES)
