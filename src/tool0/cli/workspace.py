"""``tool0 workspace``: the robot as catkin packages, for Noetic and Gazebo 11."""

from __future__ import annotations

import shlex
import time
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Final

from tool0.cli.parameters import Option
from tool0.description.config import UNSET, Cell, DescriptionConfig, File, Unset
from tool0.errors import ConfigError
from tool0.installation.moveit.package import MOVEIT_SUFFIX
from tool0.installation.workspace import (
    FileAction,
    WorkspaceChanges,
    write_workspace,
)

if TYPE_CHECKING:
    from tool0.description.robot import RobotDescription

_ROBOTIQ: Final = "https://github.com/jr-robotics/robotiq.git"
"""Where robotiq_2f_85_gripper_visualization is; no distribution packages it."""


def workspace(
    folder: Annotated[Path, Option(is_positional=True, metavar="DIR")],
    *,
    arm: str | None = None,
    gripper: str | Unset | None = UNSET,
    cell: Cell | File | None = None,
    robots: Sequence[str] | None = None,
    moveit: bool = False,
    upstream_meshes: bool = False,
    force: bool = False,
) -> None:
    """Write the packages tool0_description and tool0_gazebo into a catkin workspace.

    They are written to DIR/src, or to DIR if that is the src folder of a workspace.  A
    second run updates the files, except those that you have edited.

    Args:
        folder: The workspace; it is created if it does not exist.
        arm: The arm that the launch files bring up: its name, or a folder of your own;
            ur5 if not given.
        gripper: The gripper, or none; 2f85 if not given.
        cell: Several robots, a YAML file (docs/cells.md); only with --moveit.
        robots: Several robots, such as left=ur5+2f85@0,0.4,0 right=ur5@0,-0.4,0; only
            with --moveit.
        moveit: Also write a configuration package for MoveIt 1.
        upstream_meshes: Use the meshes of ur_description and
            robotiq_2f_85_gripper_visualization, and depend on those packages.
        force: Also overwrite files that you have edited; your version is kept as
            FILE.orig.
    """
    from tool0.control.default_controllers import controllers_yaml
    from tool0.description.robot import load_description
    from tool0.installation.robot_packages import robot_packages

    description = load_description(
        DescriptionConfig(arm=arm, gripper=gripper, cell=cell, robots=robots)
    )
    if description.cell is not None:
        _check_cell(description.cell, moveit=moveit)
    controllers = controllers_yaml(description)
    action_controllers = controllers_yaml(description, gripper_action=True)
    files = robot_packages(
        description.robots,
        controllers=controllers,
        action_controllers=action_controllers,
        upstream_meshes=upstream_meshes,
    )
    if moveit:
        files |= _moveit_package(description, controllers, action_controllers)
    changes = write_workspace(folder, files, force=force)
    _print_changes(changes)
    print()
    _print_next_steps(changes, upstream_meshes=upstream_meshes)


def _check_cell(cell: Cell, *, moveit: bool) -> None:
    """Raise ConfigError if there is no package for a cell."""
    if not moveit:
        raise ConfigError(
            "the launch files of tool0_gazebo are for one robot; add --moveit to write "
            "the MoveIt package of a cell"
        )
    if cell.namespaces:
        raise ConfigError(
            "the MoveIt package is for one controller manager; write the cell without "
            "'namespaces: true'",
            cell.location,
        )


def _moveit_package(
    description: RobotDescription, controllers: str, action_controllers: str
) -> dict[PurePosixPath, bytes]:
    """Return the files of the MoveIt package, and print what they rest on."""
    import yaml

    from tool0.description.robot import named_poses
    from tool0.engines.mujoco.gl import import_mujoco
    from tool0.installation.moveit.package import moveit_package

    import_mujoco()
    from tool0.engines.mujoco.link_collisions import N_SAMPLES, disabled_collisions

    start = time.perf_counter()
    home = named_poses(description).get("home", {})
    disabled = disabled_collisions(description.model, home)
    files = moveit_package(
        description,
        disabled=disabled,
        controllers=yaml.safe_load(controllers),
        action_controllers=yaml.safe_load(action_controllers),
    )
    print(
        f"collisions between {len(disabled)} pairs of links are disabled, from "
        f"{N_SAMPLES} poses in {time.perf_counter() - start:.1f} s"
    )
    return files


def _print_changes(changes: WorkspaceChanges) -> None:
    counts = (
        f"{len(changes.paths(action))} {action.value}"
        for action in FileAction
        if changes.paths(action)
    )
    *first, last = (str(changes.source / name) for name in changes.packages)
    packages = f"{', '.join(first)} and {last}" if first else last
    print(f"{packages}: files {', '.join(counts)}")
    for path, aside in changes.backups.items():
        print(f"  overwritten: {path}; your version: {aside}")
    kept = changes.paths(FileAction.KEEP)
    for path in kept:
        print(f"  kept: {path}; you have edited it")
    if kept:
        print("  --force overwrites them, and puts your versions beside them (.orig)")


def _print_next_steps(changes: WorkspaceChanges, *, upstream_meshes: bool) -> None:
    source = changes.source
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
    if "tool0_gazebo" in changes.packages:
        print("  roslaunch tool0_gazebo bringup.launch")
    print("  roslaunch tool0_description view.launch   # RViz alone")
    for package in changes.packages:
        if package.endswith(MOVEIT_SUFFIX):
            print(f"  roslaunch {package} demo.launch   # MoveIt without a robot")
