"""Lists the parts of ROS 1 that tool0 uses, and the ways to install missing parts."""

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
from typing import Final, TypedDict, final

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
    """A part of ROS 1.  All packages of a part are installed together."""

    name: str
    purpose: str
    """Purpose of the part, as text for users."""
    modules: tuple[str, ...] = ()
    """Python modules to import.  Each module is in a package of the same name."""
    programs: tuple[str, ...] = ()
    """Programs that must be in PATH."""
    nodes: tuple[str, ...] = ()
    """Programs that rosrun can start, in the form ``package/program``."""
    definitions: tuple[str, ...] = ()
    """Packages whose ``.msg`` files are read."""
    other_packages: tuple[tuple[str, str], ...] = ()
    """Packages in addition to the packages of ``modules``, each with its names in ROS
    and in Debian."""
    is_needed: bool = False
    """Whether ROS 1 cannot be used without this component."""

    @property
    def contents(self) -> tuple[str, ...]:
        """Names of the component's parts."""
        definitions = (f"{name}/msg" for name in self.definitions)
        return (*self.modules, *self.programs, *self.nodes, *definitions)

    @property
    def debian(self) -> tuple[str, ...]:
        """Names of the component's packages in Debian and Ubuntu."""
        return (
            *(f"python3-{name.replace('_', '-')}" for name in self.modules),
            *(f"ros-{name.replace('_', '-')}" for name in self.definitions),
            *(debian for _, debian in self.other_packages),
        )

    @property
    def ros(self) -> tuple[str, ...]:
        """Names of the component's packages in a ROS distribution such as Noetic."""
        return (*self.modules, *(ros for ros, _ in self.other_packages))

    def missing(self) -> tuple[str, ...]:
        """Return the names of missing parts.  Nothing is imported.

        The modules of Debian's packages are found only after ``import_ros``.
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
    """Return the components that must be installed."""
    return tuple(one for one in COMPONENTS if rviz or one.name != "rviz")


def other_install_command(components: Iterable[RosComponent]) -> str:
    """Return the install command for a ROS that is not from the distribution."""
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


class Ros1Json(TypedDict):
    """The status as data for JSON."""

    can_run: bool
    """Whether ``tool0 bringup --ros1`` works if a master is running."""
    rospy: str | None
    """The folder from which rospy is imported; null if there is no rospy."""
    version: str | None
    """Version of rospy."""
    source: str | None
    """The origin of the ROS packages."""
    master: str
    """The expected address of the ROS master."""
    is_master_up: bool
    """Whether the ROS master answers."""
    parts: dict[str, bool]
    """Whether a component is complete, by component."""
    missing: dict[str, tuple[str, ...]]
    """Missing parts of each incomplete component, by component."""
    messages: dict[str, str]
    """Origin of each message package, by name: ``installed`` or ``ours``."""
    remedies: tuple[str, ...]
    """Commands that install the missing parts."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros1Status:
    """The output of ``tool0 ros1 status``."""

    rospy: Path | None = None
    """The folder from which rospy is imported."""
    version: str | None = None
    """Version of rospy."""
    source: str | None = None
    """The origin of the ROS packages."""
    master: str
    """The expected address of the ROS master."""
    is_master_up: bool = False
    """Whether the ROS master answers."""
    missing: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Missing parts of each incomplete component, by component."""
    messages: dict[str, str] = field(default_factory=dict)
    """Origin of each message package, by name: ``installed`` or ``ours``."""
    remedies: tuple[str, ...] = ()
    """Commands that install the missing parts."""

    @property
    def can_run(self) -> bool:
        """Whether ``tool0 bringup --ros1`` works if a master is running."""
        needed = (part.name for part in COMPONENTS if part.is_needed)
        return self.rospy is not None and self.missing.keys().isdisjoint(needed)

    def why_not(self, names: Iterable[str]) -> str | None:
        """Return why a component cannot be used; None if all components can be used."""
        absent = [name for name in names if name in self.missing]
        gaps = [f"no {', '.join(self.missing[name])}" for name in absent]
        return "; ".join([*gaps, *self.remedies]) if gaps else None

    def as_json(self) -> Ros1Json:
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
        """Return the names and values of the status as text."""
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
    """Return the status. rospy is imported, but no program is started."""
    master = os.environ.get("ROS_MASTER_URI", DEFAULT_MASTER)
    try:
        import_ros()
        _import_rospy()
    except RosUnavailableError as error:
        everything = {part.name: part.contents for part in COMPONENTS}
        return Ros1Status(master=master, missing=everything, remedies=(str(error),))
    try:
        is_up = Master("/tool0_status").is_up
    except RosUnavailableError:  # the address of the master is invalid
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
            # tool0 cannot fix the cause of the warnings
            warnings.simplefilter("ignore")
            importlib.import_module("rospy")
    except ImportError as error:
        raise RosUnavailableError(
            f"rospy is in '{rospy_folder()}' but cannot be imported ({error}); install "
            f"its requirements into '{sys.prefix}', such as: pip install rospkg"
        ) from None
