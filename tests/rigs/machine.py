"""A machine to examine or install on, in a folder: its programs, files and ROS 2."""

from __future__ import annotations

import json
from pathlib import Path

from tool0.installation.machine import Machine
from tool0.installation.ros2.installation import current_link, mark_complete, own_folder

ANSWER = {"python": "3.12.3", "failures": {}, "rmw": "rmw_fastrtps_cpp"}


def add_program(path: Path, script: str = "") -> Path:
    """Write a shell script that can be run, and return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return path


def make_machine(
    root: Path,
    *programs: str,
    release: str = "",
    system: str = "linux",
    **variables: str,
) -> Machine:
    """Return a machine with these programs, which do nothing.

    Args:
        root: Its file system; programs are in ``bin``.
        programs: Names.
        release: The text of ``/etc/os-release``.
        system: As ``sys.platform``.
        variables: Of its environment.
    """
    for name in programs:
        add_program(root / "bin" / name)
    (root / "etc").mkdir(exist_ok=True)
    (root / "etc/os-release").write_text(release)
    environ = {"PATH": str(root / "bin"), **variables}
    return Machine(root=root, environ=environ, system=system)


def add_gazebo_header(root: Path, version: str) -> None:
    """Write the header of Gazebo that states its version."""
    header = root / "include/gazebo-11/gazebo/gazebo_config.h"
    header.parent.mkdir(parents=True)
    header.write_text(f'#define GAZEBO_VERSION_FULL "{version}"\n')


def add_ros2(
    root: Path, distro: str, *, python: str = "3.12", lacking: tuple[str, ...] = ()
) -> Path:
    """Write a ROS 2 in ``root``, whose Python answers as if it had all but ``lacking``.

    Its setup file sets SOURCED to the name of the distribution.
    """
    prefix = root / distro
    (prefix / "lib" / f"python{python}" / "site-packages" / "rclpy").mkdir(parents=True)
    add_manifest(prefix)
    answer = ANSWER | {"failures": {name: f"no {name}" for name in lacking}}
    script = f"echo some noise\necho '{json.dumps(answer)}'"
    add_program(prefix / "bin" / f"python{python}", script)
    (prefix / "setup.bash").write_text(
        f"export SOURCED={distro} AMENT_PREFIX_PATH={prefix} ROS_DISTRO={distro}\n"
        "echo a message\n"
    )
    return prefix


def add_own_ros2(name: str = "kilted-py3.12-1") -> Path:
    """Write what passes for ``tool0 ros2 install``'s, and select it."""
    prefix = own_folder() / name
    add_program(prefix / "bin" / "python", f"echo '{json.dumps(ANSWER)}'")
    add_manifest(prefix)
    mark_complete(prefix, distro="kilted", size=123_456_789)
    current_link().symlink_to(prefix.name)
    return prefix


def add_manifest(prefix: Path) -> None:
    """Write the manifest of rclpy."""
    (prefix / "share" / "rclpy").mkdir(parents=True)
    text = '<package format="3">\n  <version compatibility="1">9.1.2</version>\n'
    (prefix / "share" / "rclpy" / "package.xml").write_text(text)
