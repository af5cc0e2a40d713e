"""``tool0 workspace``: the robot as catkin packages, for Noetic and Gazebo 11."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Final

from tool0.cli.parameters import Option
from tool0.installation.workspace import (
    PACKAGES,
    FileAction,
    WorkspaceChanges,
    write_workspace,
)

_ROBOTIQ: Final = "https://github.com/jr-robotics/robotiq.git"
"""Where robotiq_2f_85_gripper_visualization is; no distribution packages it."""


def workspace(
    folder: Annotated[Path, Option(is_positional=True, metavar="DIR")],
    *,
    upstream_meshes: bool = False,
    force: bool = False,
) -> None:
    """Write the packages tool0_description and tool0_gazebo into a catkin workspace.

    They are written to DIR/src, or to DIR if that is the src folder of a workspace.  A
    second run updates the files, except those that you have edited.

    Args:
        folder: The workspace; it is created if it does not exist.
        upstream_meshes: Use the meshes of ur_description and
            robotiq_2f_85_gripper_visualization, and depend on those packages.
        force: Also overwrite files that you have edited; your version is kept as
            FILE.orig.
    """
    changes = write_workspace(folder, upstream_meshes=upstream_meshes, force=force)
    _print_changes(changes)
    print()
    _print_next_steps(changes.source, upstream_meshes=upstream_meshes)


def _print_changes(changes: WorkspaceChanges) -> None:
    counts = (
        f"{len(changes.paths(action))} {action.value}"
        for action in FileAction
        if changes.paths(action)
    )
    packages = " and ".join(str(changes.source / name) for name in PACKAGES)
    print(f"{packages}: files {', '.join(counts)}")
    for path, aside in changes.backups.items():
        print(f"  overwritten: {path}; your version: {aside}")
    kept = changes.paths(FileAction.KEEP)
    for path in kept:
        print(f"  kept: {path}; you have edited it")
    if kept:
        print("  --force overwrites them, and puts your versions beside them (.orig)")


def _print_next_steps(source: Path, *, upstream_meshes: bool) -> None:
    sources = next((p for p in (source, *source.parents) if p.name == "src"), source)
    name = shlex.quote(sources.name)
    option = "" if sources.name == "src" else f" --source {name}"
    print("next, where /opt/ros/noetic/setup.bash is sourced:")
    print(f"  cd {shlex.quote(str(sources.parent))}")
    if upstream_meshes:
        print(f"  git clone {_ROBOTIQ} {name}/robotiq")
    print(f"  rosdep install --from-paths {name} --ignore-src --rosdistro noetic -y")
    print(f"  catkin_make{option}")
    print("  source devel/setup.bash")
    print("  roslaunch tool0_gazebo ur5_robotiq_2f_85_bringup.launch")
    print("  roslaunch tool0_description view_ur5_robotiq_2f_85.launch   # RViz alone")
