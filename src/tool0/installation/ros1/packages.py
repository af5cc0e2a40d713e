"""Lists the parts of ROS 1 that tool0 uses, and how to install missing parts."""

from __future__ import annotations

import importlib
import importlib.util
import os
import shutil
import sys
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, final

from tool0.errors import RosUnavailableError
from tool0.installation.ros1.library import (
    DEFAULT_MASTER,
    find_node,
    import_ros,
    is_of_distribution,
    message_folders,
    package_prefix,
    package_version,
    ros_origin,
    rospy_folder,
)
from tool0.installation.ros1.master import Master
from tool0.installation.ros1.messages import absent_packages, package_names


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RosComponent:
    """A part of ROS 1 that is installed as a whole."""

    name: str
    purpose: str
    """Purpose of the part, for users."""
    modules: tuple[str, ...] = ()
    """Python modules to import; each is in a package of the same name."""
    programs: tuple[str, ...] = ()
    """Required programs on PATH."""
    nodes: tuple[str, ...] = ()
    """Programs that rosrun would start, as ``package/program``."""
    definitions: tuple[str, ...] = ()
    """Packages whose ``.msg`` files are read."""
    other_packages: tuple[tuple[str, str], ...] = ()
    """Packages in addition to those of ``modules``: name in ROS, name in Debian."""
    is_needed: bool = False
    """Whether ROS 1 cannot be used without this component."""

    @property
    def contents(self) -> tuple[str, ...]:
        """Names of the component's parts."""
        definitions = (f"{name}/msg" for name in self.definitions)
        return (*self.modules, *self.programs, *self.nodes, *definitions)

    @property
    def debian(self) -> tuple[str, ...]:
        """The component's packages in Debian and Ubuntu."""
        return (
            *(f"python3-{name.replace('_', '-')}" for name in self.modules),
            *(f"ros-{name.replace('_', '-')}" for name in self.definitions),
            *(debian for _, debian in self.other_packages),
        )

    @property
    def ros(self) -> tuple[str, ...]:
        """The component's packages in a ROS distribution, such as Noetic."""
        return (*self.modules, *(ros for ros, _ in self.other_packages))

    def missing(self) -> tuple[str, ...]:
        """Return the names of missing parts, without importing anything.

        Debian's modules are on the path only after ``import_ros``.
        """
        return (
            *(name for name in self.modules if not importlib.util.find_spec(name)),
            *(name for name in self.programs if not shutil.which(name)),
            *(name for name in self.nodes if find_node(name) is None),
            *(f"{name}/msg" for name in self.definitions if not message_folders(name)),
        )


_TOOLS: Final = ("rostopic", "rosservice", "rosnode", "rosparam", "rosmsg")

COMPONENTS: Final = (
    RosComponent(
        name="rospy",
        purpose="the client library",
        modules=("rospy", "rosgraph"),
        is_needed=True,
    ),
    RosComponent(
        name="actionlib",
        purpose="actions: trajectories and the gripper",
        modules=("actionlib",),
        is_needed=True,
    ),
    RosComponent(
        name="messages",
        purpose="types of topics and services",
        modules=(
            *("genpy", "genmsg", "std_msgs", "std_srvs", "rosgraph_msgs"),
            *("geometry_msgs", "sensor_msgs", "trajectory_msgs"),
            *("actionlib_msgs", "tf2_msgs"),
        ),
        definitions=(
            *("std_msgs", "geometry_msgs", "sensor_msgs"),
            *("trajectory_msgs", "actionlib_msgs"),
        ),
        is_needed=True,
    ),
    RosComponent(
        name="roscore",
        purpose="starting a master: --roscore",
        modules=("rosmaster", "roslaunch"),
        programs=("roscore",),
        nodes=("rosout/rosout",),
        other_packages=(("rosout", "rosout"),),
    ),
    RosComponent(
        name="robot_state_publisher",
        purpose="/tf by the usual node; without it, tool0 publishes /tf",
        nodes=("robot_state_publisher/robot_state_publisher",),
        other_packages=(("robot_state_publisher", "ros-robot-state-publisher"),),
    ),
    RosComponent(
        name="tf2",
        purpose="transforms in Python",
        modules=("tf2_ros",),
    ),
    RosComponent(
        name="tools",
        purpose="rostopic, rosservice, rosnode, rosparam, rosmsg",
        programs=_TOOLS,
        other_packages=tuple((name, f"python3-{name}") for name in _TOOLS),
    ),
    RosComponent(
        name="rviz",
        purpose="showing the robot in RViz",
        programs=("rviz",),
        other_packages=(("rviz", "rviz"),),
    ),
)


def required_components(*, rviz: bool) -> tuple[RosComponent, ...]:
    """Return the components to install."""
    return tuple(one for one in COMPONENTS if rviz or one.name != "rviz")


def other_install_command(components: Iterable[RosComponent]) -> str:
    """Return the install command for a ROS from outside the distribution."""
    distro = os.environ.get("ROS_DISTRO", "noetic")
    names = (name.replace("_", "-") for one in components for name in one.ros)
    packages = " ".join(f"ros-{distro}-{name}" for name in dict.fromkeys(names))
    if ros_origin() == "RoboStack":
        return f"mamba install -c conda-forge -c robostack-{distro} {packages}"
    prefix = package_prefix("rospy")
    if prefix is not None and prefix.is_relative_to("/opt/ros"):
        return f"sudo apt-get install {packages}"
    return f"install in the workspace that rospy is from: {packages}"


# --- what is installed ---


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros1Status:
    """The output of ``tool0 ros1 status``."""

    rospy: Path | None = None
    """The folder that rospy is imported from."""
    version: str | None = None
    """Version of rospy."""
    source: str | None = None
    """The origin of ROS's packages."""
    master: str
    """The expected address of the master."""
    is_master_up: bool = False
    """Whether the master answers."""
    missing: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Component → missing parts; complete components are left out."""
    messages: dict[str, str] = field(default_factory=dict)
    """Message package → ``installed``, or ``ours``."""
    remedies: tuple[str, ...] = ()
    """The command that installs what is missing."""

    @property
    def can_run(self) -> bool:
        """Whether ``tool0 bringup --ros1`` works, given a master."""
        needed = (part.name for part in COMPONENTS if part.is_needed)
        return self.rospy is not None and self.missing.keys().isdisjoint(needed)

    def why_not(self, names: Iterable[str]) -> str | None:
        """Return why these components cannot all be used; None if they can."""
        absent = [name for name in names if name in self.missing]
        gaps = [f"no {', '.join(self.missing[name])}" for name in absent]
        return "; ".join([*gaps, *self.remedies]) if gaps else None

    def as_json(self) -> dict[str, object]:
        """Return the status as data for JSON."""
        return {
            "can_run": self.can_run,
            "rospy": None if self.rospy is None else str(self.rospy),
            "version": self.version,
            "source": self.source,
            "master": self.master,
            "is_master_up": self.is_master_up,
            "parts": {part.name: part.name not in self.missing for part in COMPONENTS},
            "missing": self.missing,
            "messages": self.messages,
            "remedies": self.remedies,
        }

    def rows(self) -> list[tuple[str, str]]:
        """Return names and values as text."""
        master = "does not answer: start roscore, or add --roscore"
        if self.is_master_up:
            master = "answers"
        kinds = {
            "installed": "installed",
            "ours": "missing: tool0 generates its own",
        }
        return [
            ("master", f"{self.master}, {master}"),
            *((part.name, self._about(part)) for part in COMPONENTS),
            *((name, kinds[kind]) for name, kind in self.messages.items()),
            *(("to do", text) for text in self.remedies),
        ]

    def _about(self, part: RosComponent) -> str:
        missing = self.missing.get(part.name, ())
        if part.name == "rospy" and not missing:
            return f"{self.version or 'unknown version'}, {self.source}, {self.rospy}"
        if not missing:
            return "there"
        found_none = len(missing) == len(part.contents)
        state = "none" if found_none else f"incomplete, no {', '.join(missing)}"
        return f"{state}; for {part.purpose}"


def ros1_status() -> Ros1Status:
    """Return the status; imports rospy, but starts nothing."""
    master = os.environ.get("ROS_MASTER_URI", DEFAULT_MASTER)
    try:
        import_ros()
        _import_rospy()
    except RosUnavailableError as error:
        everything = {part.name: part.contents for part in COMPONENTS}
        return Ros1Status(master=master, missing=everything, remedies=(str(error),))
    try:
        is_up = Master("/tool0_status").is_up
    except RosUnavailableError:  # its address is invalid
        is_up = False
    found, absent = {p.name: p.missing() for p in COMPONENTS}, absent_packages()
    missing = {name: what for name, what in found.items() if what}
    remedy = f"tool0 ros1 install{' --rviz' if 'rviz' in missing else ''}"
    if not is_of_distribution():
        remedy = other_install_command(p for p in COMPONENTS if p.name in missing)
    return Ros1Status(
        rospy=rospy_folder(),
        version=package_version("rospy"),
        source=ros_origin(),
        master=master,
        is_master_up=is_up,
        missing=missing,
        messages={
            name: "ours" if name in absent else "installed" for name in package_names()
        },
        remedies=(remedy,) if missing else (),
    )


def _import_rospy() -> None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # tool0 cannot fix that
            importlib.import_module("rospy")
    except ImportError as error:
        raise RosUnavailableError(
            f"rospy is in '{rospy_folder()}' but cannot be imported ({error}); install "
            f"its requirements into '{sys.prefix}', such as: pip install rospkg"
        ) from None
