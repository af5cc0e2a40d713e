"""What tool0 uses of ROS 1, whether it is installed, and its packages."""

from __future__ import annotations

import importlib.util
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RosComponent:
    """A part of ROS 1 that is installed as a whole."""

    name: str
    purpose: str
    """What needs it."""
    modules: tuple[str, ...] = ()
    """Python modules to import; each has a package of its name."""
    programs: tuple[str, ...] = ()
    """Programs on PATH."""
    nodes: tuple[str, ...] = ()
    """Programs that rosrun would start, as ``package/program``."""
    definitions: tuple[str, ...] = ()
    """Packages whose ``.msg`` files are read."""
    other_packages: tuple[tuple[str, str], ...] = ()
    """Packages besides those of ``modules``: name in ROS, name in Debian and Ubuntu."""
    is_needed: bool = False
    """Whether nothing works without it."""

    @property
    def contents(self) -> tuple[str, ...]:
        """All that it consists of, by name."""
        definitions = (f"{name}/msg" for name in self.definitions)
        return (*self.modules, *self.programs, *self.nodes, *definitions)

    @property
    def debian(self) -> tuple[str, ...]:
        """Its packages in Debian and Ubuntu."""
        return (
            *(f"python3-{name.replace('_', '-')}" for name in self.modules),
            *(f"ros-{name.replace('_', '-')}" for name in self.definitions),
            *(debian for _, debian in self.other_packages),
        )

    @property
    def ros(self) -> tuple[str, ...]:
        """Its packages in a distribution of ROS, such as Noetic."""
        return (*self.modules, *(ros for ros, _ in self.other_packages))


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
        purpose="a master of one's own: --roscore",
        modules=("rosmaster", "roslaunch"),
        programs=("roscore",),
        nodes=("rosout/rosout",),
        other_packages=(("rosout", "rosout"),),
    ),
    RosComponent(
        name="robot_state_publisher",
        purpose="/tf by the usual node; without it tool0 publishes /tf itself",
        nodes=("robot_state_publisher/robot_state_publisher",),
        other_packages=(("robot_state_publisher", "ros-robot-state-publisher"),),
    ),
    RosComponent(
        name="tf2",
        purpose="looking transforms up in Python",
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
        purpose="seeing the robot in RViz",
        programs=("rviz",),
        other_packages=(("rviz", "rviz"),),
    ),
)


def required_components(*, rviz: bool) -> tuple[RosComponent, ...]:
    """Return the components to install."""
    return tuple(one for one in COMPONENTS if rviz or one.name != "rviz")


def missing_of(component: RosComponent) -> tuple[str, ...]:
    """Return what of the component is missing, by name; nothing is imported.

    Debian's modules are on no path before ``import_ros``.
    """
    roots = prefixes()
    return (
        *(name for name in component.modules if not importlib.util.find_spec(name)),
        *(name for name in component.programs if not shutil.which(name)),
        *(name for name in component.nodes if find_node(name) is None),
        *(
            f"{name}/msg"
            for name in component.definitions
            if not any((root / "share" / name / "msg").is_dir() for root in roots)
        ),
    )


def find_node(name: str) -> Path | None:
    """Return the program of the node ``package/program``, as rosrun finds it."""
    files = (root / "lib" / name for root in prefixes())
    return next((file for file in files if os.access(file, os.X_OK)), None)


def prefixes() -> tuple[Path, ...]:
    """Return where ROS packages are installed, a workspace's first."""
    named = os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    folders = [Path(name) for name in named if name]
    own = package_prefix("rospy")
    return tuple(dict.fromkeys(folders if own is None else [*folders, own]))


def package_prefix(module: str) -> Path | None:
    """Return the prefix that the package of a module is installed in."""
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None:
        return None
    manifest = Path("share", module, "package.xml")
    folders = Path(spec.origin).parents
    return next((folder for folder in folders if (folder / manifest).is_file()), None)


def package_version(module: str) -> str | None:
    """Return the version in the manifest of the package of a module."""
    from xml.etree import ElementTree

    prefix = package_prefix(module)
    if prefix is None:
        return None
    manifest = prefix / "share" / module / "package.xml"
    return ElementTree.parse(manifest).getroot().findtext("version")
