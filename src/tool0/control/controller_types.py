"""The controller types that can be loaded, under the names of ros_controllers."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from tool0.control.controller import ControllerSpec
from tool0.control.parameters import Robot
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, SourceLocation, did_you_mean

Parser = Callable[[Namespace, Robot], ControllerSpec]

_FORWARD = "tool0.control.forward_command"

_MODULES = {
    "joint_state_controller/JointStateController": "tool0.control.joint_state",
    "effort_controllers/JointTrajectoryController": (
        "tool0.control.joint_trajectory_spec"
    ),
    "position_controllers/JointTrajectoryController": (
        "tool0.control.joint_trajectory_spec"
    ),
    "velocity_controllers/JointTrajectoryController": (
        "tool0.control.joint_trajectory_spec"
    ),
    "effort_controllers/GripperActionController": "tool0.control.gripper_action",
    "position_controllers/GripperActionController": "tool0.control.gripper_action",
    "effort_controllers/JointEffortController": _FORWARD,
    "effort_controllers/JointPositionController": _FORWARD,
    "effort_controllers/JointVelocityController": _FORWARD,
    "effort_controllers/JointGroupEffortController": _FORWARD,
    "effort_controllers/JointGroupPositionController": _FORWARD,
    "position_controllers/JointPositionController": _FORWARD,
    "position_controllers/JointGroupPositionController": _FORWARD,
    "velocity_controllers/JointPositionController": _FORWARD,
    "velocity_controllers/JointVelocityController": _FORWARD,
    "velocity_controllers/JointGroupVelocityController": _FORWARD,
}
"""Where each type's ``parse(parameters, robot)`` is defined."""

TYPES = tuple(sorted(_MODULES))


def parser_of(type_name: str, location: SourceLocation | None = None) -> Parser:
    """Return the function that reads the parameters of a type.

    Raises:
        ConfigError: If there is no such type.
    """
    module = _MODULES.get(type_name)
    if module is None:
        hint = did_you_mean(type_name, list(TYPES))
        known = "" if hint.startswith("; valid") else f" (of {', '.join(TYPES)})"
        raise ConfigError(
            f"unknown controller type '{type_name}'{hint}{known}", location
        )
    parse: Parser = import_module(module).parse
    return parse
