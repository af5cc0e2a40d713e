"""Creates the catkin packages of an arm with a gripper, for Noetic and Gazebo 11.

The files are those that tool0 itself reads.  The chosen robot is the default of the
arguments in these files.  Only the controllers are generated for one robot, because
their gains depend on the robot.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Final

from tool0.description.catalogue import NO_GRIPPER, CataloguePart
from tool0.description.packages import BUNDLED
from tool0.description.robot import CatalogueRobot
from tool0.errors import ConfigError

PACKAGES: Final = ("tool0_description", "tool0_gazebo")
UPSTREAM_PACKAGES: Final = ("ur_description", "robotiq_2f_85_gripper_visualization")
"""Packages whose meshes can replace tool0's meshes."""
_HOME: Final = "home"
"""Name of the start pose."""
_NOT_WRITTEN: Final = re.compile(
    r"((native|started)_)?controllers(_gripper_action|_ros2)?\.yaml|gains\.yaml"
)
"""Configuration files that only tool0 reads.  These files contain parts of
controllers."""
_LAST_DEPENDENCY: Final = b"  <exec_depend>xacro</exec_depend>\n"

Files = dict[PurePosixPath, bytes]
"""Content of each file, by path relative to the folder of packages."""


def robot_packages(
    robots: Sequence[CatalogueRobot],
    *,
    controllers: str,
    action_controllers: str,
    upstream_meshes: bool = False,
) -> Files:
    """Return the files of tool0_description and, for a single robot, tool0_gazebo.

    Args:
        robots: The robot that launch files bring up by default, without a prefix, or
            the robots of a cell.
        controllers: The YAML of the controllers for ros_control.
        action_controllers: The YAML of the controllers, but with a gripper that is
            driven by an action.
        upstream_meshes: Whether the meshes of ``UPSTREAM_PACKAGES`` are the default.
            If the meshes are the default, the packages are dependencies.

    Raises:
        ConfigError: If the folder of your own arm or gripper cannot be added to the
            built-in folders.
    """
    robot = robots[0]
    packages = PACKAGES[:1] if robot.name else PACKAGES
    files = described_packages(robots, packages, upstream_meshes=upstream_meshes)
    config = PurePosixPath("tool0_gazebo/config")
    texts = {
        "controllers": controllers,
        "controllers_gripper_action": action_controllers,
    }
    for kind, text in texts.items() if "tool0_gazebo" in packages else ():
        name = f"{robot.arm.name}_{gripper_name(robot)}_{kind}.yaml"
        files[config / name] = _for_gazebo(text, robot.gripper, kind).encode()
    if upstream_meshes:
        _depend_on_upstream(files)
    return files


def described_packages(
    robots: Sequence[CatalogueRobot],
    packages: Sequence[str],
    *,
    upstream_meshes: bool = False,
) -> Files:
    """Return the files of packages, with the robots as default arguments.

    Args:
        robots: One robot, or the robots of a cell.  The first robot of a cell is the
            default.
        packages: The names of the packages, including ``tool0_description``.
        upstream_meshes: Whether the meshes of ``UPSTREAM_PACKAGES`` are the default.

    Raises:
        ConfigError: If the folder of your own arm or gripper cannot be added to the
            built-in folders.
    """
    own = [_own_part(part) for robot in robots for part in robot.parts]
    robot = robots[0]
    defaults = {
        "arm": robot.arm.name,
        "gripper": gripper_name(robot),
        "meshes": "upstream" if upstream_meshes else "tool0",
        "initial_joint_positions": " ".join(
            f"-J {joint} {position}"
            for joint, position in robot.arm.load("poses").get(_HOME, {}).items()
        ),
    }
    files = {
        PurePosixPath(path.relative_to(BUNDLED).as_posix()): path.read_bytes()
        for package in packages
        for path in _files_in(BUNDLED / package)
    }
    files = {path: _with_defaults(data, defaults) for path, data in files.items()}
    for part_files in own:
        files |= part_files
    return files


def gripper_name(robot: CatalogueRobot) -> str:
    """Return the name of the gripper, or ``none`` if there is no gripper."""
    return NO_GRIPPER if robot.gripper is None else robot.gripper.name


def _files_in(folder: Path) -> list[Path]:
    """Return the files of a package or of a part of it.

    Temporary files of tools are omitted.
    """
    return [
        path
        for path in sorted(folder.rglob("*"))
        if path.is_file()
        and not _NOT_WRITTEN.fullmatch(path.name)
        and not any(
            name.startswith((".", "__pycache__"))
            for name in path.relative_to(folder).parts
        )
    ]


def _with_defaults(data: bytes, defaults: Mapping[str, str]) -> bytes:
    """Return a file in which declared arguments have other default values."""
    for name, value in defaults.items():
        declared = rf'(<(?:xacro:)?arg name="{name}" default=")[^"]+(")'
        data = re.sub(declared.encode(), rf"\g<1>{value}\g<2>".encode(), data)
    return data


def _own_part(part: CataloguePart) -> Files:
    """Return the files of your own arm or gripper.

    The result is empty for a built-in arm or gripper.

    Raises:
        ConfigError: If the name of the part is the name of a built-in arm or gripper,
            or if the name is not a valid file name.
    """
    if part.is_built_in:
        return {}
    below = PurePosixPath(f"tool0_description/config/{part.kind}s", part.name)
    if (BUNDLED / below).exists():
        raise ConfigError(
            f"'{part.folder}' is called like a built-in {part.kind}; rename the folder"
        )
    if not re.fullmatch(r"\w+", part.name, re.ASCII):
        raise ConfigError(
            f"'{part.folder}': the name of the folder becomes part of names in ROS; "
            "use letters, digits and underscores"
        )
    return {
        below / path.relative_to(part.folder).as_posix(): path.read_bytes()
        for path in _files_in(part.folder)
    }


def _for_gazebo(text: str, gripper: CataloguePart | None, kind: str) -> str:
    """Return the controllers' YAML with the gripper's controllers for native Gazebo.

    The file ``native_<kind>.yaml`` in the gripper's folder replaces the controllers
    that have the same names.
    """
    path = None if gripper is None else gripper.folder / f"native_{kind}.yaml"
    if path is None or not path.is_file():
        return text
    import yaml

    native = path.read_text(encoding="utf-8")
    for name in yaml.safe_load(native):
        block = rf"(?:^#.*\n)*^{name}:.*\n(?:(?:[ #].*)?\n)*?(?=^#.*\n|^\S|\Z)"
        text = re.sub(block, "", text, flags=re.MULTILINE)
    return f"{text.rstrip()}\n\n{native}"


def _depend_on_upstream(files: Files) -> None:
    depends = "".join(
        f'  <exec_depend condition="$ROS_VERSION == 1">{name}</exec_depend>\n'
        for name in sorted(UPSTREAM_PACKAGES)
    )
    manifest = PurePosixPath("tool0_description", "package.xml")
    files[manifest] = files[manifest].replace(
        _LAST_DEPENDENCY, depends.encode() + _LAST_DEPENDENCY
    )
