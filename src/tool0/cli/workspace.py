"""``tool0 workspace``: the robot as catkin packages, for Noetic and Gazebo 11."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import tyro

if TYPE_CHECKING:
    from tool0.installation.workspace.writing import WorkspaceChanges

_ROBOTIQ: Final = "https://github.com/jr-robotics/robotiq.git"
"""Where robotiq_2f_85_gripper_visualization is; no distribution packages it."""


def workspace(
    folder: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="DIR")],
    *,
    upstream_meshes: bool = False,
    force: bool = False,
) -> None:
    """Write the packages tool0_description and tool0_gazebo into a catkin workspace.

    They go into DIR/src, or into DIR if that is the src of a workspace.  Run again, it
    updates what it wrote before, and leaves alone what you have edited since.

    Args:
        folder: The workspace; made if it is not there.
        upstream_meshes: Let the robot look as ur_description and
            robotiq_2f_85_gripper_visualization draw it, and depend on those packages.
        force: Overwrite files that you have edited, too; your version stays beside
            each, as FILE.orig.
    """
    from tool0.installation.workspace.writing import write_workspace

    changes = write_workspace(folder, upstream_meshes=upstream_meshes, force=force)
    for line in report(changes):
        print(line)
    print()
    for line in next_steps(changes.source, upstream_meshes=upstream_meshes):
        print(line)


def report(changes: WorkspaceChanges) -> Iterator[str]:
    """Yield what was done with the files, for people."""
    from tool0.installation.workspace.layout import PACKAGES
    from tool0.installation.workspace.writing import FileAction

    counts = (
        f"{len(changes.paths(action))} {action.value}"
        for action in FileAction
        if changes.paths(action)
    )
    packages = " and ".join(str(changes.source / name) for name in PACKAGES)
    yield f"{packages}: files {', '.join(counts)}"
    for path, aside in changes.backups.items():
        yield f"  overwritten: {path}; your version: {aside}"
    kept = changes.paths(FileAction.KEEP)
    for path in kept:
        yield f"  kept: {path}; you have edited it"
    if kept:
        yield "  --force overwrites them, and puts your versions beside them (.orig)"


def next_steps(source: Path, *, upstream_meshes: bool) -> Iterator[str]:
    """Yield the commands that a person types next."""
    sources = next((p for p in (source, *source.parents) if p.name == "src"), source)
    name = shlex.quote(sources.name)
    option = "" if sources.name == "src" else f" --source {name}"
    yield "next, where /opt/ros/noetic/setup.bash is sourced:"
    yield f"  cd {shlex.quote(str(sources.parent))}"
    if upstream_meshes:
        yield f"  git clone {_ROBOTIQ} {name}/robotiq"
    yield f"  rosdep install --from-paths {name} --ignore-src --rosdistro noetic -y"
    yield f"  catkin_make{option}"
    yield "  source devel/setup.bash"
    yield "  roslaunch tool0_gazebo ur5_robotiq_2f_85_bringup.launch"
    yield "  roslaunch tool0_description view_ur5_robotiq_2f_85.launch   # RViz alone"
