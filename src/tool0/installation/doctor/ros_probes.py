"""Probes of Gazebo, ROS 1 and ROS 2, and of what builds a catkin workspace."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tool0.errors import RosUnavailableError
from tool0.installation.doctor.machine import ExaminedMachine
from tool0.installation.doctor.report import ProbeResult, ProbeState

if TYPE_CHECKING:
    from tool0.installation.ros1.status import Ros1Status

_INSTALL_GAZEBO: Final = "tool0 gazebo install"
_INSTALL_ROS1: Final = "tool0 ros1 install --rviz"
_DISTRO: Final = "noetic"
_BUILD_TOOLS: Final = {"catkin_make": "catkin", "cmake": "cmake", "make": "make"}
"""Program → its package in Debian."""
_LAUNCHED_PACKAGES: Final = (
    *("gazebo_ros", "gazebo_ros_control", "controller_manager", "effort_controllers"),
    *("joint_state_controller", "robot_state_publisher", "xacro"),
    "rqt_joint_trajectory_controller",
)
"""What the launch files of ``tool0 workspace`` start."""
_ADD_SOURCES: Final = (
    "add its packages first, http://wiki.ros.org/noetic/Installation/Ubuntu"
)


def gazebo(examined: ExaminedMachine) -> list[ProbeResult]:
    """Return which Gazebo ``--engine gazebo`` runs, and whether it has a window."""
    if examined.system != "linux":
        found = f"by tool0 on {examined.name()}: Gazebo 11 runs on Linux"
        return [ProbeResult(what="gazebo", state="not supported", found=found)]
    from tool0.installation.gazebo.status import gazebo_status

    status = gazebo_status()
    if not status.can_run:
        compiler = examined.install_command(
            "g++", dnf="gcc-c++", zypper="gcc-c++", pacman="gcc"
        )
        return [
            ProbeResult(
                what="gazebo",
                state="missing",
                found="; ".join(status.missing),
                remedy=compiler if status.version else f"{_INSTALL_GAZEBO} --gui",
            )
        ]
    origin = "the system's" if status.prefix is None else "tool0's own"
    bridge = "" if status.is_compiled else ", its bridge compiled at the first start"
    found = f"{status.version}, {origin}, {status.server}{bridge}"
    window = ProbeResult(what="gazebo window", state="ready", found=str(status.client))
    if status.client is None:
        window = ProbeResult(
            what="gazebo window",
            state="missing",
            found="no gzclient, for --gazebo-gui",
            remedy=f"{_INSTALL_GAZEBO} --gui --private",
        )
    return [ProbeResult(what="gazebo", state="ready", found=found), window]


def ros1(examined: ExaminedMachine) -> list[ProbeResult]:
    """Return whether ``tool0 bringup --ros1`` works, and what else of ROS 1 exists."""
    from tool0.installation.ros1.status import ros1_status

    status = ros1_status()
    if not status.can_run:
        return [_without_ros1(status)]
    master = f"{status.master} answers"
    if not status.is_master_up:
        master = f"no master answers at {status.master}: add --roscore"
    found = f"rospy {status.version}, {status.source}, {status.rospy}; {master}"
    others = [name for name in status.missing if name != "rviz"]
    remedy = "; ".join(status.remedies)
    return [
        ProbeResult(what="ros1", state="ready", found=found),
        ProbeResult(
            what="ros1 tools",
            state="missing" if others else "ready",
            found=", ".join(others) or "roscore, rostopic and the like",
            remedy=remedy if others else "",
        ),
        ProbeResult(
            what="rviz",
            state="missing" if "rviz" in status.missing else "ready",
            found=examined.program("rviz") or "for seeing the robot in RViz",
            remedy=remedy if "rviz" in status.missing else "",
        ),
    ]


def _without_ros1(status: Ros1Status) -> ProbeResult:
    from tool0.installation.ros1.install import is_packaged, plan_install

    try:
        plan_install(rviz=False)
    except RosUnavailableError as error:  # it says who packages it, or what is wrong
        can_have = status.rospy is not None or is_packaged()
        state: ProbeState = "missing" if can_have else "not supported"
        return ProbeResult(what="ros1", state=state, found=str(error))
    missing = [name for names in status.missing.values() for name in names]
    first = ", ".join(missing[:4]) + ", …" * (len(missing) > 4)
    return ProbeResult(
        what="ros1",
        state="missing",
        found=f"no {first}; for --ros1",
        remedy=_INSTALL_ROS1,
    )


def ros2(examined: ExaminedMachine) -> list[ProbeResult]:
    """Return what there is of ROS 2, which tool0 does not support yet."""
    pattern = "*/lib/python3*/site-packages/rclpy"
    homes = sorted((examined.root / "opt/ros").glob(pattern))
    distros = [f"{home.parents[3]} with rclpy" for home in homes]
    spec = None if distros else importlib.util.find_spec("rclpy")
    if spec is not None and spec.origin is not None:
        distros = [f"rclpy in {spec.origin}"]
    found = f"by tool0 yet; {', '.join(distros) or 'nothing of it is here'}"
    return [ProbeResult(what="ros2", state="not supported", found=found)]


def workspace(examined: ExaminedMachine) -> list[ProbeResult]:
    """Return whether the packages of ``tool0 workspace`` build and launch here."""
    return [_catkin(examined), _native_gazebo_ros(examined)]


def _catkin(examined: ExaminedMachine) -> ProbeResult:
    from tool0.installation.ros1.install import PYTHON_OF_RELEASE

    setup = examined.root / "opt/ros" / _DISTRO / "setup.bash"
    programs = {name: examined.program(name) for name in _BUILD_TOOLS}
    missing = [name for name, path in programs.items() if path is None]
    state: ProbeState = "missing"
    found = f"no {', '.join(missing)}; for building what `tool0 workspace` writes"
    remedy = ""
    if not missing:
        state, found = "ready", f"{programs['catkin_make']}, {programs['cmake']}"
    elif setup.is_file() and "catkin_make" in missing:
        remedy = f"source {setup}"
    elif examined.codename() in PYTHON_OF_RELEASE or "catkin_make" not in missing:
        packages = " ".join(_BUILD_TOOLS[name] for name in missing)
        remedy = examined.install_command(packages)
    else:
        state, found = "not supported", f"by {examined.name()}: {found}"
    return ProbeResult(what="catkin", state=state, found=found, remedy=remedy)


def _native_gazebo_ros(examined: ExaminedMachine) -> ProbeResult:
    noetic = examined.root / "opt/ros" / _DISTRO
    named = examined.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    prefixes = [
        *(Path(name) for name in named if name),
        noetic,
        examined.root / "usr",
    ]
    folders = {name: _package_folder(name, prefixes) for name in _LAUNCHED_PACKAGES}
    missing = [name for name, folder in folders.items() if folder is None]
    purpose = "for roslaunch of what `tool0 workspace` writes"
    state: ProbeState = "missing"
    remedy = ""
    if not missing:
        state, found = "ready", str(folders["gazebo_ros_control"])
    elif noetic.is_dir():
        found = f"no {', '.join(missing)}; {purpose}"
        names = (f"ros-{_DISTRO}-{name.replace('_', '-')}" for name in missing)
        remedy = f"sudo apt install {' '.join(names)}"
    elif examined.codename() == "focal":
        found = f"no Noetic; {purpose}; {_ADD_SOURCES}"
        remedy = f"sudo apt install ros-{_DISTRO}-desktop-full"
    else:
        state = "not supported"
        found = (
            f"by {examined.name()}, only by Ubuntu 20.04 with Noetic; here, "
            "`tool0 bringup --engine gazebo --ros1` presents the same"
        )
    return ProbeResult(
        what="native gazebo_ros", state=state, found=found, remedy=remedy
    )


def _package_folder(package: str, prefixes: list[Path]) -> Path | None:
    folders = (prefix / "share" / package for prefix in prefixes)
    return next((one for one in folders if (one / "package.xml").is_file()), None)
