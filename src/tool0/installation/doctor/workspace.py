"""What builds the packages of ``tool0 workspace``, and what runs them natively."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from tool0.installation.doctor.line import Line
from tool0.installation.doctor.machine import Machine

_DISTRO: Final = "noetic"
_BUILDERS: Final = {"catkin_make": "catkin", "cmake": "cmake", "make": "make"}
"""Program → its package in Debian."""
_NATIVE: Final = (
    *("gazebo_ros", "gazebo_ros_control", "controller_manager", "effort_controllers"),
    *("joint_state_controller", "robot_state_publisher", "xacro"),
    "rqt_joint_trajectory_controller",
)
"""What the launch files of ``tool0 workspace`` start."""
_FIRST: Final = "add its packages first, http://wiki.ros.org/noetic/Installation/Ubuntu"
_HAVE_CATKIN: Final = frozenset({"bookworm", "trixie", "jammy"})


def workspace(here: Machine) -> list[Line]:
    """Tell whether the packages can be built here, and whether native Gazebo runs."""
    return [_build(here), _native(here)]


def _build(here: Machine) -> Line:
    setup = here.root / "opt/ros" / _DISTRO / "setup.bash"
    programs = {name: here.program(name) for name in _BUILDERS}
    lacking = [name for name, path in programs.items() if path is None]
    if not lacking:
        found = f"{programs['catkin_make']}, {programs['cmake']}"
        return Line(what="catkin", state="ready", found=found)
    found = f"no {', '.join(lacking)}; for building what `tool0 workspace` writes"
    if setup.is_file() and "catkin_make" in lacking:
        return _missing(found, f"source {setup}")
    if here.codename() in _HAVE_CATKIN or "catkin_make" not in lacking:
        packages = " ".join(_BUILDERS[name] for name in lacking)
        return _missing(found, here.install(packages))
    return Line(
        what="catkin", state="not supported", found=f"by {here.name()}: {found}"
    )


def _missing(found: str, remedy: str) -> Line:
    return Line(what="catkin", state="missing", found=found, remedy=remedy)


def _native(here: Machine) -> Line:
    what = "native gazebo_ros"
    noetic = here.root / "opt/ros" / _DISTRO
    named = here.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    prefixes = [*(Path(name) for name in named if name), noetic, here.root / "usr"]
    at = {name: _folder(name, prefixes) for name in _NATIVE}
    lacking = [name for name, folder in at.items() if folder is None]
    if not lacking:
        return Line(what=what, state="ready", found=str(at["gazebo_ros_control"]))
    purpose = "for roslaunch of what `tool0 workspace` writes"
    if noetic.is_dir():
        names = (f"ros-{_DISTRO}-{name.replace('_', '-')}" for name in lacking)
        return Line(
            what=what,
            state="missing",
            found=f"no {', '.join(lacking)}; {purpose}",
            remedy=f"sudo apt install {' '.join(names)}",
        )
    if here.codename() == "focal":
        return Line(
            what=what,
            state="missing",
            found=f"no Noetic; {purpose}; {_FIRST}",
            remedy=f"sudo apt install ros-{_DISTRO}-desktop-full",
        )
    return Line(
        what=what,
        state="not supported",
        found=f"by {here.name()}, only by Ubuntu 20.04 with Noetic; here, "
        "`tool0 bringup --engine gazebo --ros1` presents the same",
    )


def _folder(package: str, prefixes: list[Path]) -> Path | None:
    folders = (prefix / "share" / package for prefix in prefixes)
    return next((one for one in folders if (one / "package.xml").is_file()), None)
