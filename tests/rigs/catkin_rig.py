"""A catkin workspace as a person has it: written by tool0, built, and looked into."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from promised import absent, require_ros

PROGRAMS = ("catkin_make", "catkin_lint", "check_urdf", "cmake", "make", "roslaunch")
STAND_INS: Mapping[str, tuple[str, ...]] = {
    "controller_manager": ("spawner",),
    "gazebo_ros": ("spawn_model",),
    "joint_state_publisher_gui": ("joint_state_publisher_gui",),
    "moveit_fake_controller_manager": (),
    "moveit_kinematics": (),
    "moveit_planners_ompl": (),
    "moveit_ros_move_group": ("move_group",),
    "moveit_ros_visualization": (),
    "moveit_setup_assistant": ("moveit_setup_assistant",),
    "moveit_simple_controller_manager": (),
    "rqt_joint_trajectory_controller": ("rqt_joint_trajectory_controller",),
}
"""Packages that Debian lacks, and their nodes that the launch files name.

They are found and do nothing: what is launched is not run with them.
"""
_WORLD = """\
<launch>
  <arg name="world_name"/>
  <arg name="gui"/>
  <arg name="paused"/>
  <param name="/gazebo_started/world_name" value="$(arg world_name)"/>
  <param name="/gazebo_started/gui" value="$(arg gui)"/>
  <param name="/gazebo_started/paused" value="$(arg paused)"/>
</launch>
"""
_MANIFEST = """\
<package format="2">
  <name>{name}</name><version>0.0.0</version><description>stands in</description>
  <maintainer email="tool0@example.org">tests</maintainer><license>none</license>
</package>
"""
_XACRO = """\
#!{python}
# PyPI's xacro, which asks ROS 2 where packages are; here ROS 1 says it.
import sys
from types import ModuleType
from pathlib import Path
import os

def get_package_share_directory(name):
    for entry in os.environ["ROS_PACKAGE_PATH"].split(os.pathsep):
        if (Path(entry) / name / "package.xml").is_file():
            return str(Path(entry) / name)
    raise LookupError(name)

sys.modules["ament_index_python"] = ModuleType("ament_index_python")
packages = ModuleType("packages")
packages.get_package_share_directory = get_package_share_directory
sys.modules["ament_index_python.packages"] = packages

import xacro
xacro.main()
"""


def require_catkin() -> None:
    """Skip visibly, or fail if this run promised ROS 1, without catkin's tools."""
    require_ros()
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    if missing:
        absent("ros1", f"not installed: {', '.join(missing)}")


class Catkin:
    """A workspace, what Debian's packages make of it, and what they lack."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.source = folder / "src"
        self.install = folder / "install"
        programs = folder.parent / "programs"
        self.stand_ins = folder.parent / "stand_ins"
        self._write_stand_ins()
        _write_program(programs / "xacro", _XACRO.replace("{python}", sys.executable))
        self.environment = {
            "PATH": f"{programs}:/usr/bin:/bin",  # Debian's tools need Debian's Python
            "HOME": str(folder.parent),
            "LANG": "C.UTF-8",
            "ROS_VERSION": "1",  # as where a ROS 1 is sourced
            "ROS_PYTHON_VERSION": "3",
            "ROS_PACKAGE_PATH": f"{self.source}:{self.stand_ins}:/usr/share",
            "ROS_MASTER_URI": "http://127.0.0.1:1",  # nothing here may need one
        }

    def _write_stand_ins(self) -> None:
        for name, nodes in STAND_INS.items():
            package = self.stand_ins / name
            package.mkdir(parents=True)
            (package / "package.xml").write_text(_MANIFEST.format(name=name))
            for node in nodes:
                _write_program(package / node, "#!/bin/sh\nexit 1\n")
        launch = self.stand_ins / "gazebo_ros" / "launch"
        launch.mkdir()
        (launch / "empty_world.launch").write_text(_WORLD)

    def add_package(self, name: str) -> Path:
        """Add one more stand-in and return its folder."""
        package = self.stand_ins / name
        package.mkdir()
        (package / "package.xml").write_text(_MANIFEST.format(name=name))
        return package

    def run(
        self, *command: str | Path, **variables: str
    ) -> subprocess.CompletedProcess[str]:
        """Run a program to its end in the workspace."""
        return subprocess.run(
            [str(word) for word in command],
            cwd=self.folder,
            env=self.environment | variables,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    def out(self, *command: str | Path, **variables: str) -> str:
        """Return what a program prints; it has to succeed."""
        answer = self.run(*command, **variables)
        assert answer.returncode == 0, (command, answer.stdout, answer.stderr)
        return answer.stdout

    def parameters(self, package: str, file: str, *args: str) -> dict[str, Any]:
        """Return what roslaunch would set."""
        text = self.out("roslaunch", "--dump-params", package, file, *args)
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
        found: dict[str, Any] = yaml.load(text, loader) or {}
        return found

    def nodes(self, package: str, file: str, *args: str) -> set[str]:
        """Return the nodes that roslaunch would start."""
        return set(self.out("roslaunch", "--nodes", package, file, *args).split())

    def node_arguments(self, node: str, package: str, file: str, *args: str) -> str:
        """Return the command line of a node."""
        return self.out("roslaunch", "--args", node, package, file, *args)


def _write_program(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)


def sourced(catkin: Catkin, setup: Path) -> dict[str, str]:
    """Return the variables that a shell has after ``source setup.bash``."""
    text = catkin.out("bash", "-c", f"source '{setup}' && env -0")
    pairs = (row.partition("=") for row in text.split("\0") if row)
    return {name: value for name, _, value in pairs}
