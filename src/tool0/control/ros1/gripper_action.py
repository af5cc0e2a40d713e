"""ROS 1's GripperActionController: its parameters."""

from __future__ import annotations

from tool0.control.gripper_action import GripperActionSpec
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    read_gains,
    single_joint,
)
from tool0.description.model import Interface
from tool0.description.yaml_values import Namespace
from tool0.protocol.controllers import Gains


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> GripperActionSpec:
    """Return the checked parameters of a GripperActionController."""
    interface = INTERFACE_OF_PACKAGE[type_name.partition("/")[0]]
    joint = single_joint(robot, parameters, interface)
    gains: tuple[Gains, ...] = ()
    if interface is Interface.EFFORT:
        why = f"{type_name} needs"
        gains = (read_gains(parameters, f"gains/{joint.name}", why),)
    max_effort = joint.limits.effort
    if parameters.find("max_effort") is not None:
        max_effort = abs(parameters.number("max_effort"))
    return GripperActionSpec(
        name=name,
        type=type_name,
        joint=joint,
        interface=interface,
        gains=gains,
        goal_tolerance=abs(parameters.number("goal_tolerance", 0.01)),
        max_effort=max_effort,
        stall_velocity_threshold=parameters.not_negative(
            "stall_velocity_threshold", 0.001
        ),
        stall_timeout=parameters.not_negative("stall_timeout", 1.0),
        allow_stalling=parameters.boolean("allow_stalling", default=False),
        action_monitor_rate=parameters.not_negative("action_monitor_rate", 20.0),
    )
