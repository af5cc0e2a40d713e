"""The controller types that can be loaded, and the parameters that each reads."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from importlib import import_module

from tool0.control.controller import ControllerSpec
from tool0.control.parameters import RobotJoints
from tool0.description.yaml_tree import Tree
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, SourceLocation, did_you_mean

Parser = Callable[[Namespace, RobotJoints], ControllerSpec]

_FORWARD = "tool0.control.forward_command"
_GRIPPER = "tool0.control.gripper_action"
_TRAJECTORY = "tool0.control.joint_trajectory"
_MODULES = {
    "joint_state_controller/JointStateController": "tool0.control.joint_state",
    "effort_controllers/JointTrajectoryController": _TRAJECTORY,
    "position_controllers/JointTrajectoryController": _TRAJECTORY,
    "velocity_controllers/JointTrajectoryController": _TRAJECTORY,
    "effort_controllers/GripperActionController": _GRIPPER,
    "position_controllers/GripperActionController": _GRIPPER,
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

_SAMPLE = """
sample:
  type: {type_name}
  joint: "*"
  joints: ["*"]
  publish_rate: 1
  gains: {{"*": {{p: 1}}}}
  pid: {{p: 1}}
  "*": {{pid: {{p: 1}}}}
"""
"""A controller of the joint ``*`` with every parameter that any type requires."""


def parser_of(type_name: str, location: SourceLocation | None = None) -> Parser:
    """Return the function that reads the parameters of a type.

    Raises:
        ConfigError: If there is no such type.
    """
    module = _MODULES.get(type_name)
    if module is None:
        hint = did_you_mean(type_name, TYPES)
        known = "" if hint.startswith("; valid") else f" (of {', '.join(TYPES)})"
        raise ConfigError(
            f"unknown controller type '{type_name}'{hint}{known}", location
        )
    parse: Parser = import_module(module).parse
    return parse


@cache
def parameters_of(type_name: str) -> frozenset[str]:
    """Return the parameters that a type reads besides ``type``; ``*`` is a joint.

    They are what the type's parser looks up in a sample, so that a parameter is added
    in the parser alone.

    Raises:
        ConfigError: If there is no such type.
    """
    tree = Tree()
    tree.load(_SAMPLE.format(type_name=type_name), SourceLocation(None, 1))
    sample = Namespace(tree.root.children["sample"])
    parser_of(type_name)(sample, RobotJoints.assumed("*", type_name))
    return sample.read_keys() - {"type"}


def siblings(parameter: str, known: Iterable[str]) -> set[str]:
    """Return the names of the known parameters beside ``parameter``."""
    prefix = parameter[: parameter.rfind("/") + 1]
    return {
        name.removeprefix(prefix).partition("/")[0]
        for name in known
        if name.startswith(prefix)
    }


def readers_of(parameter: str) -> tuple[str, ...]:
    """Return the kinds of controllers that read a parameter, without packages."""
    readers = {name for name in TYPES if parameter in parameters_of(name)}
    return tuple(sorted({name.partition("/")[2] for name in readers}))
