"""Grippers of ROS 2: the parameters of their three controllers.

Its ``GripperActionController`` are those of ROS 1, by position or by effort.
The parallel one commands positions, and sets speed and effort of the drive through
command interfaces of their own.
"""

from __future__ import annotations

import math

from tool0.control.gripper_action import DriveSettings, GripperActionSpec
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    read_gains,
    single_joint,
)
from tool0.description.model import Interface, Joint
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean
from tool0.protocol.controllers import Gains

_ADJUSTABLE = (
    *("goal_tolerance", "allow_stalling", "stall_velocity_threshold"),
    *("stall_timeout", "max_effort", "max_velocity"),
)


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> GripperActionSpec:
    """Return the checked parameters of a gripper's controller."""
    package = type_name.partition("/")[0]
    interface = INTERFACE_OF_PACKAGE.get(package, Interface.POSITION)
    joint = single_joint(robot, parameters, interface)
    gains: tuple[Gains, ...] = ()
    settings: DriveSettings | None = None
    states: tuple[str, ...] = ("position", "velocity")
    if package == "parallel_gripper_action_controller":
        settings = _settings(parameters, robot, joint)
        states = parameters.texts("state_interfaces", states)
        max_effort = joint.limits.effort
    else:
        max_effort = parameters.not_negative("max_effort", 0.0) or joint.limits.effort
    if interface is Interface.EFFORT:
        path = f"gains/{joint.name}"
        gains = (read_gains(parameters, path, f"{type_name} needs"),)
        adjustable = (f"{path}/{gain}" for gain in ("p", "i", "d", "i_clamp"))
        parameters.mark_adjustable(*adjustable)
    parameters.mark_adjustable(*_ADJUSTABLE)
    return GripperActionSpec(
        name=name,
        type=type_name,
        joint=joint,
        interface=interface,
        gains=gains,
        goal_tolerance=parameters.not_negative("goal_tolerance", 0.01),
        max_effort=max_effort,
        stall_velocity_threshold=parameters.not_negative(
            "stall_velocity_threshold", 0.001
        ),
        stall_timeout=parameters.not_negative("stall_timeout", 1.0),
        allow_stalling=parameters.boolean("allow_stalling", default=False),
        action_monitor_rate=_monitor_rate(parameters),
        state_interfaces=tuple(f"{joint.name}/{state}" for state in states),
        settings=settings,
    )


def _monitor_rate(parameters: Namespace) -> float:
    rate = parameters.number("action_monitor_rate", 20.0)
    entry = parameters.find("action_monitor_rate")
    if entry is not None and not 0.1 <= rate < math.inf:
        raise ConfigError(
            f"'{entry.key}' must be at least 0.1 [Hz], got {rate}", entry.location
        )
    return rate


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
    """Return the command interface that is named, if any; the hardware must have it."""
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
