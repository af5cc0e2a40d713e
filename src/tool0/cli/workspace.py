"""``tool0 workspace``: writes the robot as packages for Noetic or for ROS 2."""

from __future__ import annotations

import shlex
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from tool0.cli import options
from tool0.cli.parameters import Option
from tool0.description.config import UNSET, Cell, DescriptionConfig, File, Unset
from tool0.errors import ConfigError
from tool0.installation.moveit.configuration import MOVEIT_SUFFIX
from tool0.installation.workspace import (
    FileAction,
    WorkspaceChanges,
    write_workspace,
)

if TYPE_CHECKING:
    from tool0.description.robot import RobotDescription
    from tool0.installation.robot_packages import Files

READERS = options.READERS

_ROBOTIQ: Final = "https://github.com/jr-robotics/robotiq.git"
"""Repository of robotiq_2f_85_gripper_visualization, a package that no ROS distribution
contains."""


def workspace(
    folder: Annotated[Path, Option(is_positional=True, metavar="DIR")],
    *,
    arm: str | None = None,
    gripper: str | Unset | None = UNSET,
    cell: Cell | File | None = None,
    robots: Sequence[str] | None = None,
    ros2: bool = False,
    moveit: bool = False,
    upstream_meshes: bool = False,
    force: bool = False,
) -> None:
    """Write ROS packages for a robot into a workspace.

    The packages for ROS 1 are tool0_description and tool0_gazebo.  With --ros2, they
    are tool0_description, tool0_ros2 and tool0_bringup.  The packages are written to
    DIR/src, or to DIR if DIR is the src folder of a workspace.  A second run updates
    all files that you have not edited.

    Args:
        folder: The folder of the workspace; it is created if it does not exist.
        arm: The arm that the launch files bring up: a name, or a folder with your own
            arm; the default is ur5.
        gripper: The gripper, or none; the default is 2f85.
        cell: YAML file with several robots (docs/how-to/cells.md); it requires --moveit
            or --ros2.
        robots: Several robots, such as left=ur5+2f85@0,0.4,0 right=ur5@0,-0.4,0; this
            option requires --moveit or --ros2.
        ros2: Write packages for ROS 2 and colcon, with Python launch files.
        moveit: Also write a MoveIt configuration package for the same ROS version.
        upstream_meshes: For ROS 1: use the meshes of ur_description and
            robotiq_2f_85_gripper_visualization, and depend on these packages.
        force: Also overwrite files that you have edited; your version is renamed to
            FILE.orig.
    """
    from tool0.description.loading import load_description

    description = load_description(
        DescriptionConfig(
            arm=arm, gripper=gripper, cell=cell, robots=robots, ros2_control=ros2
        )
    )
    if description.cell is not None:
        _check_cell(description.cell, is_written=moveit or ros2)
    if not ros2:
        files = _catkin_files(description, upstream_meshes, moveit)
    elif upstream_meshes:
        raise ConfigError(
            "--upstream-meshes is for ROS 1: robotiq_2f_85_gripper_visualization does "
            "not exist for ROS 2"
        )
    else:
        files = _colcon_files(description, moveit)
    changes = write_workspace(folder, files, force=force)
    _print_changes(changes)
    print()
    if ros2:
        _print_colcon_steps(changes)
    else:
        _print_catkin_steps(changes, upstream_meshes=upstream_meshes)


def _check_cell(cell: Cell, *, is_written: bool) -> None:
    """Raise ConfigError if the requested packages do not support cells."""
    if not is_written:
        raise ConfigError(
            "the launch files of tool0_gazebo are for one robot; add --moveit to write "
            "the MoveIt package of a cell, or --ros2 for ROS 2"
        )
    if cell.namespaces:
        raise ConfigError(
            "the packages are for one controller manager; write the cell without "
            "'namespaces: true'",
            cell.location,
        )


def _catkin_files(
    description: RobotDescription, upstream_meshes: bool, moveit: bool
) -> Files:
    """Return the packages for ROS 1."""
    import yaml

    from tool0.control.default_controllers import controllers_yaml
    from tool0.installation.moveit.package import moveit_package
    from tool0.installation.robot_packages import robot_packages

    controllers = controllers_yaml(description)
    with_action = controllers_yaml(description, gripper_action=True)
    files = robot_packages(
        description.robots,
        controllers=controllers,
        action_controllers=with_action,
        upstream_meshes=upstream_meshes,
    )
    if moveit:
        files |= moveit_package(
            description,
            disabled=_disabled_collisions(description),
            controllers=yaml.safe_load(controllers),
            action_controllers=yaml.safe_load(with_action),
        )
    return files


def _colcon_files(description: RobotDescription, moveit: bool) -> Files:
    """Return the packages for ROS 2."""
    from tool0.control.default_controllers import controllers_yaml
    from tool0.installation.colcon.bringup import colcon_packages, controller_parameters
    from tool0.installation.moveit.ros2_package import moveit2_package
    from tool0.simulation.config import ControlConfig
    from tool0.simulation.controllers import choose_controllers

    controllers = controllers_yaml(description)
    started = choose_controllers(description, ControlConfig()).started
    files = colcon_packages(description, controllers=controllers, started=started)
    if moveit:
        parameters, limits = controller_parameters(controllers)
        files |= moveit2_package(
            description,
            disabled=_disabled_collisions(description),
            controllers=parameters,
            limits=limits,
        )
    return files


def _disabled_collisions(
    description: RobotDescription,
) -> Mapping[tuple[str, str], str]:
    """Return the pairs of links that MoveIt does not check, and print their number."""
    from tool0.description.loading import named_poses
    from tool0.engines.mujoco.gl import import_mujoco

    import_mujoco()
    from tool0.engines.mujoco.link_collisions import N_SAMPLES, disabled_collisions

    start = time.perf_counter()
    home = named_poses(description).get("home", {})
    disabled = disabled_collisions(description.model, home)
    print(
        f"collisions between {len(disabled)} pairs of links are disabled, from "
        f"{N_SAMPLES} poses in {time.perf_counter() - start:.1f} s"
    )
    return disabled


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


def _root_and_source(changes: WorkspaceChanges) -> tuple[Path, str]:
    """Return the workspace, and the name of its source folder."""
    source = changes.source
    sources = next((p for p in (source, *source.parents) if p.name == "src"), source)
    return sources.parent, shlex.quote(sources.name)


def _print_catkin_steps(changes: WorkspaceChanges, *, upstream_meshes: bool) -> None:
    root, name = _root_and_source(changes)
    option = "" if name == "src" else f" --source {name}"
    print("next, where /opt/ros/noetic/setup.bash is sourced:")
    print(f"  cd {shlex.quote(str(root))}")
    if upstream_meshes:
        print(f"  git clone {_ROBOTIQ} {name}/robotiq")
    print(f"  rosdep install --from-paths {name} --ignore-src --rosdistro noetic -y")
    print(f"  catkin_make{option}")
    print("  source devel/setup.bash")
    if "tool0_gazebo" in changes.packages:
        print("  roslaunch tool0_gazebo bringup.launch")
    print("  roslaunch tool0_description view.launch   # RViz alone")
    for package in _moveit_packages(changes):
        print(f"  roslaunch {package} demo.launch   # MoveIt without a robot")


def _print_colcon_steps(changes: WorkspaceChanges) -> None:
    root, name = _root_and_source(changes)
    option = "" if name == "src" else f" --base-paths {name}"
    print("next, where /opt/ros/DISTRO/setup.bash is sourced:")
    print(f"  cd {shlex.quote(str(root))}")
    print(f"  rosdep install --from-paths {name} --ignore-src -y")
    print(f"  colcon build{option}")
    print("  source install/setup.bash")
    print("  ros2 launch tool0_bringup tool0.launch.py   # simulated by tool0")
    print("  ros2 launch tool0_bringup gz.launch.py      # by Gazebo")
    print("  ros2 launch tool0_bringup view.launch.py    # RViz alone")
    for package in _moveit_packages(changes):
        print(f"  ros2 launch {package} move_group.launch.py")
        print(f"  ros2 launch {package} demo.launch.py   # MoveIt without a robot")


def _moveit_packages(changes: WorkspaceChanges) -> list[str]:
    return [name for name in changes.packages if name.endswith(MOVEIT_SUFFIX)]
