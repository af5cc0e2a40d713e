"""Finds ROS 2 nodes that use the wall clock although a simulation runs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from tool0.description.finding import Finding, warning_at
from tool0.lint.launch.model import Include, LaunchFile, Node

_SIMULATIONS: Final = ("ros_gz_sim", "ros_ign_gazebo", "gazebo_ros", "webots_ros2")
_STAMPING: Final = ("robot_state_publisher", "move_group", "servo_node")
"""Programs that compare or publish time stamps, and that fail if their clock is not the
simulation's clock."""
_NAME: Final = "use_sim_time"


def missing_sim_time(launch: LaunchFile) -> Iterator[Finding]:
    """Yield the nodes of a ROS 2 launch file that lack ``use_sim_time``."""
    if not launch.is_python or not _simulates(launch):
        return
    for node in launch.nodes():
        program = node.type.resolved
        if program not in _STAMPING or _is_set(node) or node.place.holds is None:
            continue
        yield warning_at(
            node.place.location,
            "no-sim-time",
            program,
            "runs with a simulation but without use_sim_time: its stamps are wall time "
            "and do not match those of the simulation",
            f'add {{"{_NAME}": True}} to its parameters',
        )


def _simulates(launch: LaunchFile) -> bool:
    for entry in launch.walk():
        if isinstance(entry, Include) and any(
            f"$(find {name})" in entry.file.raw for name in _SIMULATIONS
        ):
            return True
        if isinstance(entry, Node) and entry.package.resolved in _SIMULATIONS:
            return True
    return False


def _is_set(node: Node) -> bool:
    """Return whether the parameter is set, or may be set in a file or conditionally."""
    named = any(parameter.name.resolved == _NAME for parameter in node.parameters)
    in_file = any(
        rosparam.yaml is None or _NAME in rosparam.yaml.raw
        for rosparam in node.rosparams
    )
    return named or in_file
