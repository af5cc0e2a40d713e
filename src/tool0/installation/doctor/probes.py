"""Examines the machine, Gazebo, ROS, and the tools for a catkin workspace."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from pathlib import Path
from typing import Final

from tool0.errors import RosUnavailableError
from tool0.installation.child_process import run_program
from tool0.installation.doctor.report import ProbeResult, ProbeState
from tool0.installation.machine import (
    Machine,
    pip_install_command,
    python_package_version,
    python_requirements,
)

PROGRAM_TIMEOUT: Final = 2.0
"""Timeout of nvidia-smi [wall s]."""
_VENDORS: Final = {"0x10de": "NVIDIA", "0x1002": "AMD", "0x8086": "Intel"}
_INSTALL_GAZEBO: Final = "tool0 gazebo install --gui"
_INSTALL_ROS1: Final = "tool0 ros1 install --rviz"
_DISTRO: Final = "noetic"
_BUILD_TOOLS: Final = {"catkin_make": "catkin", "cmake": "cmake", "make": "make"}
"""Debian package of each program."""
_LAUNCHED_PACKAGES: Final = (
    *("gazebo_ros", "gazebo_ros_control", "controller_manager", "effort_controllers"),
    *("joint_state_controller", "robot_state_publisher", "xacro"),
    "rqt_joint_trajectory_controller",
)
"""Packages with programs that are started by the launch files from ``tool0
workspace``."""


# --- the machine itself, its Python and its GPUs ---


def machine(examined: Machine) -> list[ProbeResult]:
    """Return the results for the operating system, processor and memory."""
    n_cores = os.cpu_count() or 1
    cores = f"{n_cores} core{'s' if n_cores > 1 else ''}"
    found = f"{examined.name()}, {platform.machine()}, {cores}"
    memory = re.search(r"^MemTotal:\s+(\d+) kB", examined.read("proc/meminfo"), re.M)
    if memory:
        found += f", {int(memory[1]) * 1024 / 1e9:.0f} GB of memory"
    return [ProbeResult("machine", "ready", found)]


def python(_: Machine) -> list[ProbeResult]:
    """Return the Python that runs tool0, and whether all requirements are installed."""
    found = f"{platform.python_version()}, {sys.prefix}"
    needed = python_requirements()
    missing = [name for name in needed if python_package_version(name) is None]
    if missing:
        found += f": without {', '.join(missing)}"
        remedy = pip_install_command(*(needed[name] for name in missing))
        return [ProbeResult("python", "missing", found, remedy)]
    found += f", tool0 {python_package_version('tool0') or 'of unknown version'}"
    return [ProbeResult("python", "ready", found)]


def gpu(examined: Machine) -> list[ProbeResult]:
    """Return the GPUs. tool0 does not need a GPU."""
    if examined.system == "darwin":
        return [ProbeResult("gpu", "ready", "the Mac's own")]
    nodes = _render_nodes(examined)
    try:
        cards = [*_nvidia_cards(examined), *nodes]
    except subprocess.TimeoutExpired:
        found = "nvidia-smi does not answer: NVIDIA's driver hangs"
        return [ProbeResult("gpu", "unknown", found)]
    if not cards:
        found = "not present (optional): physics and browsers can use the CPU"
        return [ProbeResult("gpu", "missing", found)]
    found, remedy = ", ".join(cards), ""
    if not all(os.access(node, os.R_OK) for node in nodes.values()):
        found += "; this account may not use it: after the command, log in again"
        remedy = 'sudo usermod -aG render "$USER"'
    return [ProbeResult("gpu", "ready", found, remedy)]


def _nvidia_cards(examined: Machine) -> list[str]:
    """Return the names of NVIDIA GPUs, and the version of their driver.

    The information is read from the driver's files.  Without these files, nvidia-smi is
    run, which may hang.
    """
    files = sorted((examined.root / "proc/driver/nvidia/gpus").glob("*/information"))
    models = (re.search(r"^Model:\s*(.+)$", file.read_text(), re.M) for file in files)
    cards = [model[1].strip() for model in models if model]
    if cards:
        text = examined.read("proc/driver/nvidia/version")
        version = re.search(r"Kernel Module\D+([\d.]+)", text)
        return [*cards, f"driver {version[1]}"] if version else cards
    program = examined.program("nvidia-smi")
    if program is None:
        return []
    answer = run_program(
        [program, "--query-gpu=name,driver_version", "--format=csv,noheader"],
        environment={**examined.environ, "LC_ALL": "C"},
        timeout=PROGRAM_TIMEOUT,
    )
    if answer.returncode != 0:  # nvidia-smi is installed, but its driver is not
        return []
    rows = answer.stdout.splitlines()
    return [row.replace(", ", ", driver ") for row in rows if row]


def _render_nodes(examined: Machine) -> dict[str, Path]:
    """Return the render nodes of the GPUs, by description."""
    nodes = {}
    for node in sorted((examined.root / "dev/dri").glob("renderD*")):
        vendor = examined.read(f"sys/class/drm/{node.name}/device/vendor").strip()
        nodes[f"{_VENDORS.get(vendor, 'a GPU')} ({node})"] = node
    return nodes


# --- Gazebo ---


def gazebo(examined: Machine) -> list[ProbeResult]:
    """Return the results for ``--engine gazebo``: the simulator and its window."""
    if examined.system != "linux":
        found = f"by tool0 on {examined.name()}: Gazebo 11 runs on Linux"
        return [ProbeResult("gazebo", "not supported", found)]
    from tool0.installation.gazebo.status import gazebo_status

    status = gazebo_status()
    found, made = "; ".join(status.missing), status.installation
    if made is None:
        return [ProbeResult("gazebo", "missing", found, _INSTALL_GAZEBO)]
    if not status.can_run:
        names = {"dnf": "gcc-c++", "zypper": "gcc-c++", "pacman": "gcc"}
        remedy = examined.install_command("g++", **names)
        return [ProbeResult("gazebo", "missing", found, remedy)]
    origin = "the system's" if made.prefix is None else "tool0's own"
    bridge = "" if status.is_compiled else ", its bridge compiled at the first start"
    engine = f"{made.version}, {origin}, {made.server}{bridge}"
    window = ProbeResult("gazebo window", "ready", str(made.client))
    if made.client is None:
        remedy = f"{_INSTALL_GAZEBO} --private"
        found = "no gzclient, for --gazebo-gui"
        window = ProbeResult("gazebo window", "missing", found, remedy)
    return [ProbeResult("gazebo", "ready", engine), window]


# --- ROS ---


def ros1(examined: Machine) -> list[ProbeResult]:
    """Return the results for ``tool0 bringup --ros1`` and other parts of ROS 1."""
    from tool0.installation.ros1.install import PYTHON_OF_RELEASE
    from tool0.installation.ros1.packages import ros1_status

    status = ros1_status()
    if not status.can_run:
        everything = [name for names in status.missing.values() for name in names]
        can_have = status.rospy is not None or examined.codename() in PYTHON_OF_RELEASE
        return [_without_ros1(everything, can_have=can_have)]
    master = f"{status.master} answers"
    if not status.is_master_up:
        master = f"no master answers at {status.master}: add --roscore"
    found = f"rospy {status.version}, {status.source}, {status.rospy}; {master}"
    others = ", ".join(name for name in status.missing if name != "rviz")
    rviz = examined.program("rviz") or "to show the robot in RViz"
    remedy = "; ".join(status.remedies)
    tools_result = ProbeResult("ros1 tools", "ready", "roscore, rostopic and similar")
    if others:
        tools_result = ProbeResult("ros1 tools", "missing", others, remedy)
    rviz_result = ProbeResult("rviz", "ready", rviz)
    if "rviz" in status.missing:
        rviz_result = ProbeResult("rviz", "missing", rviz, remedy)
    return [ProbeResult("ros1", "ready", found), tools_result, rviz_result]


def _without_ros1(missing: list[str], *, can_have: bool) -> ProbeResult:
    from tool0.installation.ros1.install import plan_install

    try:
        plan_install(rviz=False)
    except RosUnavailableError as error:  # the message contains the remedy
        state: ProbeState = "missing" if can_have else "not supported"
        return ProbeResult("ros1", state, str(error))
    first = ", ".join(missing[:4]) + ", …" * (len(missing) > 4)
    return ProbeResult("ros1", "missing", f"no {first}; for --ros1", _INSTALL_ROS1)


def ros2(examined: Machine) -> list[ProbeResult]:
    """Return the result for ``tool0 bringup --ros2``."""
    from tool0.installation.ros2.install import why_not_installable
    from tool0.installation.ros2.status import INSTALL, ros2_status

    status = ros2_status()
    remedy = "; ".join(status.remedies)
    if status.ros2 is None:
        reason = why_not_installable()
        if reason is None:
            found = "no ROS 2; for --ros2"
            return [ProbeResult("ros2", "missing", found, INSTALL)]
        return [ProbeResult("ros2", "not supported", f"no ROS 2; {reason}")]
    found = (
        f"{status.ros2.distro}, {status.ros2.origin}, rclpy {status.rclpy}, "
        f"{status.rmw}, {status.ros2.prefix}"
    )
    if status.missing:
        found = f"{status.ros2.distro} without {', '.join(status.missing)}"
    state: ProbeState = "ready" if status.can_run else "missing"
    return [ProbeResult("ros2", state, found, remedy)]


# --- the workspace ---


def workspace(examined: Machine) -> list[ProbeResult]:
    """Return the results for building and launching a ``tool0 workspace``."""
    return [_catkin(examined), _native_gazebo_ros(examined)]


def _catkin(examined: Machine) -> ProbeResult:
    from tool0.installation.ros1.install import PYTHON_OF_RELEASE

    setup = examined.root / "opt/ros" / _DISTRO / "setup.bash"
    programs = {name: examined.program(name) for name in _BUILD_TOOLS}
    missing = [name for name, path in programs.items() if path is None]
    found = f"no {', '.join(missing)}; to build the packages of `tool0 workspace`"
    if not missing:
        found = f"{programs['catkin_make']}, {programs['cmake']}"
        return ProbeResult("catkin", "ready", found)
    if setup.is_file() and "catkin_make" in missing:
        return ProbeResult("catkin", "missing", found, f"source {setup}")
    if examined.codename() in PYTHON_OF_RELEASE or "catkin_make" not in missing:
        packages = " ".join(_BUILD_TOOLS[name] for name in missing)
        remedy = examined.install_command(packages)
        return ProbeResult("catkin", "missing", found, remedy)
    return ProbeResult("catkin", "not supported", f"by {examined.name()}: {found}")


def _native_gazebo_ros(examined: Machine) -> ProbeResult:
    what, noetic = "native gazebo_ros", examined.root / "opt/ros" / _DISTRO
    named = examined.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    prefixes = [*(Path(name) for name in named if name), noetic, examined.root / "usr"]
    folders = {name: _package_folder(name, prefixes) for name in _LAUNCHED_PACKAGES}
    missing = [name for name, folder in folders.items() if folder is None]
    purpose = "to launch the packages of `tool0 workspace`"
    if not missing:
        return ProbeResult(what, "ready", str(folders["gazebo_ros_control"]))
    if noetic.is_dir():
        names = (f"ros-{_DISTRO}-{name.replace('_', '-')}" for name in missing)
        remedy = f"sudo apt install {' '.join(names)}"
        return ProbeResult(
            what, "missing", f"no {', '.join(missing)}; {purpose}", remedy
        )
    if examined.codename() == "focal":
        found = (
            f"no Noetic; {purpose}; add its packages first, "
            "http://wiki.ros.org/noetic/Installation/Ubuntu"
        )
        remedy = f"sudo apt install ros-{_DISTRO}-desktop-full"
        return ProbeResult(what, "missing", found, remedy)
    found = (
        f"by {examined.name()}, only by Ubuntu 20.04 with Noetic; here, "
        "`tool0 bringup --engine gazebo --ros1` presents the same"
    )
    return ProbeResult(what, "not supported", found)


def _package_folder(package: str, prefixes: list[Path]) -> Path | None:
    folders = (prefix / "share" / package for prefix in prefixes)
    return next((one for one in folders if (one / "package.xml").is_file()), None)
