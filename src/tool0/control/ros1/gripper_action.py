"""The parameters of GripperActionController in ROS 1."""

from __future__ import annotations

from tool0.control.gripper_action import GripperActionSpec, read_gripper_action
from tool0.control.parameters import INTERFACE_OF_PACKAGE, RobotJoints, single_joint
from tool0.description.yaml_values import Namespace


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> GripperActionSpec:
    """Return the checked parameters of a GripperActionController."""
    interface = INTERFACE_OF_PACKAGE[type_name.partition("/")[0]]
    joint = single_joint(robot, parameters, interface)
    max_effort = joint.limits.effort
    if parameters.find("max_effort") is not None:
        max_effort = abs(parameters.number("max_effort"))
    return read_gripper_action(
        name,
        type_name,
        parameters,
        joint,
        interface,
        goal_tolerance=abs(parameters.number("goal_tolerance", 0.01)),
        max_effort=max_effort,
        action_monitor_rate=parameters.not_negative("action_monitor_rate", 20.0),
        delay=robot.gripper_delay,
    )
