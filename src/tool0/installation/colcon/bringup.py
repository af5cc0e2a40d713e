"""Writes the colcon packages of a robot or a cell, for ROS 2.

``tool0_description`` is the same package as for ROS 1, and ``tool0_ros2`` contains the
node that a bring-up runs.  ``tool0_bringup`` is generated for the robot.  This package
contains launch files for tool0 and for Gazebo with gz_ros2_control, and the controllers
for both simulators.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, Final

from tool0.description.robot import CatalogueRobot, RobotDescription
from tool0.errors import ConfigError
from tool0.installation.moveit.configuration import package_stem
from tool0.installation.robot_packages import Files, described_packages, gripper_name
from tool0.installation.templates import filled

BRINGUP: Final = "tool0_bringup"
_BUNDLED: Final = ("tool0_description", "tool0_ros2")
_HERE: Final = Path(__file__).parent
_ROBOT_VALUES: Final = """    arm = LaunchConfiguration("ur_type")
    arm = share("tool0_description", "config/arms", arm)
    chosen = LaunchConfiguration("gripper")
    folder = share("tool0_description", "config/grippers", chosen)
    gripper = PythonExpression(
        ["'none' if '", chosen, "' == 'none' else '", folder, "'"]
    )
"""
_INDENT: Final = " " * 20

_BROADCASTER: Final = "joint_state_broadcaster/JointStateBroadcaster"
_TRAJECTORY: Final = "joint_trajectory_controller/JointTrajectoryController"
_FORWARD: Final = "forward_command_controller/ForwardCommandController"
_GRIPPER: Final = "parallel_gripper_action_controller/GripperActionController"
_IN_GAZEBO: Final = (_BROADCASTER, _TRAJECTORY, _FORWARD, _GRIPPER)
"""Controller types that need only positions, velocities and efforts."""
_NOT_IN_GAZEBO: Final = (
    "speed_scaling",
    "max_effort_interface",
    "max_velocity_interface",
)
"""Parameters that contain the names of interfaces that gz_ros2_control does not
have."""

Parameters = Mapping[str, Any]  # Any: values from YAML


def colcon_packages(
    description: RobotDescription, *, controllers: str, started: Sequence[str]
) -> Files:
    """Return the files of ``tool0_description``, ``tool0_ros2`` and ``tool0_bringup``.

    Args:
        description: One or more robots from the catalogue, with ``<ros2_control>``.
        controllers: The YAML text of the robot's controllers, for ROS 2.
        started: Names of the controllers that tool0 starts.

    Raises:
        ConfigError: If the folder of your own arm or gripper cannot be added to the
            built-in folders, or if no controller moves the arm.
    """
    import yaml

    parameters: Parameters = yaml.safe_load(controllers)
    name, robots = package_stem(description), description.robots
    is_cell = description.cell is not None
    in_gazebo = gazebo_controllers(parameters, _interfaces(description))
    arms = _named(in_gazebo, _TRAJECTORY)
    if not arms:
        raise ConfigError("the robot has no controller of trajectories to launch")
    stem = f"{name}_controllers"
    words = {
        "@title@": description.title,
        "@robot@": name,
        "@arm@": robots[0].arm.name,
        "@gripper@": gripper_name(robots[0]),
        "@controllers@": stem,
        "@joint_controller@": arms[0],
        "@started@": ", ".join(f'"{n}"' for n in _started_in_gazebo(in_gazebo, arms)),
        "@controllers_started@": "".join(f'    "{n}",\n' for n in started),
        "@robot_arguments@": "" if is_cell else _robot_arguments(robots[0]),
        "@robot_values@": "" if is_cell else _ROBOT_VALUES,
        "@robot_options@": _options(is_cell, name),
    }
    package = PurePosixPath(BRINGUP)
    texts = filled(_HERE / "template", package, words)
    if is_cell:
        texts |= filled(_HERE / "template_cell", package, words)
        texts[package / "urdf" / f"{name}.urdf"] = description.urdf
    texts[package / "config" / f"{stem}.yaml"] = controllers
    about = "# Controllers for gz_ros2_control, with the interfaces that it has.\n"
    texts[package / "config" / f"{stem}_gz.yaml"] = about + yaml.safe_dump(
        in_gazebo, sort_keys=False
    )
    files = described_packages(robots, _BUNDLED)
    return files | {path: text.encode() for path, text in texts.items()}


def controller_parameters(
    text: str,
) -> tuple[dict[str, dict[str, Any]], Mapping[str, Mapping[str, float]]]:
    """Return each controller's parameters and type, and the joint limits.

    ``text`` is the YAML text of the controllers for ROS 2.
    """
    import yaml

    nodes = yaml.safe_load(text)
    manager = nodes["controller_manager"]["ros__parameters"]
    parameters = {
        name: {**nodes.get(name, {}).get("ros__parameters", {}), "type": entry["type"]}
        for name, entry in manager.items()
        if isinstance(entry, dict) and "type" in entry
    }
    return parameters, manager.get("joint_limits", {})


def gazebo_controllers(
    parameters: Parameters, interfaces: frozenset[str]
) -> dict[str, Any]:  # Any: values from YAML
    """Return the parameters of the controllers that gz_ros2_control can run.

    Args:
        parameters: The parameters of all controllers and of the controller manager, by
            node.
        interfaces: The names of the joints' command interfaces, such as
            ``elbow_joint/position``.
    """
    manager = parameters["controller_manager"]["ros__parameters"]
    own = {n: v["ros__parameters"] for n, v in parameters.items() if n in manager}
    kept = {
        name: {k: v for k, v in own.get(name, {}).items() if k not in _NOT_IN_GAZEBO}
        for name, entry in manager.items()
        if isinstance(entry, dict) and entry.get("type") in _IN_GAZEBO
    }
    kept = {name: values for name, values in kept.items() if _fits(values, interfaces)}
    rate = {"update_rate": manager["update_rate"]} if "update_rate" in manager else {}
    types = {name: {"type": manager[name]["type"]} for name in kept}
    return {
        "controller_manager": {"ros__parameters": {**rate, **types}},
        **{name: {"ros__parameters": values} for name, values in kept.items()},
    }


def _fits(values: Parameters, interfaces: frozenset[str]) -> bool:
    """Return whether the interface of a forwarding controller exists."""
    kind = values.get("interface_name")
    joints = values.get("joints", ())
    return kind is None or all(f"{joint}/{kind}" in interfaces for joint in joints)


def _interfaces(description: RobotDescription) -> frozenset[str]:
    return frozenset(
        name
        for component in description.model.hardware
        for name in component.command_interfaces
    )


def _named(parameters: Parameters, kind: str) -> list[str]:
    """Return the names of the controllers of a type."""
    manager = parameters["controller_manager"]["ros__parameters"]
    return [
        name
        for name, entry in manager.items()
        if isinstance(entry, dict) and entry["type"] == kind
    ]


def _started_in_gazebo(parameters: Parameters, arms: Sequence[str]) -> list[str]:
    """Return the started controllers other than the controller of the first arm.

    These controllers are state broadcasters, gripper controllers and the controllers of
    other arms.
    """
    states, grippers = (_named(parameters, kind) for kind in (_BROADCASTER, _GRIPPER))
    return [*states, *grippers, *arms[1:]]


def _robot_arguments(robot: CatalogueRobot) -> str:
    arguments = {
        "ur_type": (
            robot.arm.name,
            "The arm: a folder of config/arms.",
        ),
        "gripper": (
            gripper_name(robot),
            "The gripper: a folder of config/grippers, or none.",
        ),
    }
    return "".join(
        f'    "{name}": ("{default}", "{about}"),\n'
        for name, (default, about) in arguments.items()
    )


def _options(is_cell: bool, name: str) -> str:
    """Return the bring-up's options that select the robot, as Python code."""
    if is_cell:
        lines = ['"--robot",', f'share("{BRINGUP}", "urdf", "{name}.urdf"),']
    else:
        lines = [
            '"--arm",',
            "arm,",
            '"--gripper",',
            "gripper,",
        ]
    return "\n".join(_INDENT + line for line in lines)
