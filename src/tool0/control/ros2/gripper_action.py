"""The parameters of the three gripper controllers of ROS 2.

The two types of ``GripperActionController``, in ``position_controllers`` and in
``effort_controllers``, work as they do in ROS 1.  The controller in
``parallel_gripper_action_controller`` commands positions, and sets the drive's speed
and effort through separate command interfaces.
"""

from __future__ import annotations

from tool0.control.gripper_action import (
    DriveSettings,
    GripperActionSpec,
    read_gripper_action,
)
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    read_at_least,
    single_joint,
)
from tool0.description.model import Interface, Joint
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean

_ADJUSTABLE = (
    *("goal_tolerance", "allow_stalling", "stall_velocity_threshold"),
    *("stall_timeout", "max_effort", "max_velocity"),
)
_GAINS = ("p", "i", "d", "i_clamp")


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> GripperActionSpec:
    """Return the checked parameters of a gripper controller."""
    package = type_name.partition("/")[0]
    interface = INTERFACE_OF_PACKAGE.get(package, Interface.POSITION)
    joint = single_joint(robot, parameters, interface)
    settings: DriveSettings | None = None
    states: tuple[str, ...] = ("position", "velocity")
    if package == "parallel_gripper_action_controller":
        settings = _settings(parameters, robot, joint)
        states = parameters.texts("state_interfaces", states)
        max_effort = joint.limits.effort
    else:
        max_effort = parameters.not_negative("max_effort", 0.0) or joint.limits.effort
    spec = read_gripper_action(
        name,
        type_name,
        parameters,
        joint,
        interface,
        goal_tolerance=parameters.not_negative("goal_tolerance", 0.01),
        max_effort=max_effort,
        action_monitor_rate=read_at_least(parameters, "action_monitor_rate", 20.0, 0.1),
        state_interfaces=tuple(f"{joint.name}/{state}" for state in states),
        settings=settings,
        delay=robot.gripper_delay,
    )
    if spec.gains:
        adjustable = (f"gains/{joint.name}/{gain}" for gain in _GAINS)
        parameters.mark_adjustable(*adjustable)
    parameters.mark_adjustable(*_ADJUSTABLE)
    return spec


def _settings(parameters: Namespace, robot: RobotJoints, joint: Joint) -> DriveSettings:
    grippers = (item for item in robot.grippers if item.joint == joint.name)
    return DriveSettings(
        gripper=next(grippers, None),
        effort_interface=_interface(parameters, robot, "max_effort_interface"),
        velocity_interface=_interface(parameters, robot, "max_velocity_interface"),
        max_effort=parameters.not_negative("max_effort", 10.0),
        max_velocity=parameters.not_negative("max_velocity", 0.1),
    )


def _interface(parameters: Namespace, robot: RobotJoints, path: str) -> str:
    """Return the command interface at ``path``, or an empty string.

    The hardware must have the command interface.
    """
    name = parameters.text(path, "")
    known = [item for each in robot.hardware for item in each.command_interfaces]
    if name and known and name not in known:
        entry = parameters.find(path) or parameters.entry
        raise ConfigError(
            f"'{entry.key}': the robot's <ros2_control> has no command interface "
            f"'{name}'{did_you_mean(name, known)}",
            entry.location,
        )
    return name
