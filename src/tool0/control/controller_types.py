"""Controllers: their interface, the types that can be loaded, and their parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from importlib import import_module
from typing import Protocol

from tool0.control.parameters import RobotJoints
from tool0.control.trajectory import Setpoint
from tool0.description.model import Interface
from tool0.description.yaml_tree import Tree
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, SourceLocation, did_you_mean
from tool0.hardware.engine import JointState


class Controller(Protocol):
    """A running controller: it exists, so it is ready; stopping drops it."""

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return a command per claimed joint, in the order of the spec's joints.

        Args:
            state: Every joint, in the engine's order.
            period: Time since the last update [s].
        """

    def setpoint(self) -> Setpoint | None:
        """Return where the joints are wanted; None if no position is.

        It is called between ticks, about a hundred times a second, so it only takes
        references to what will not change.
        """

    def stop(self) -> None:
        """End what is in progress: an active goal is PREEMPTED."""


class ControllerSpec(Protocol):
    """A loaded controller: its checked parameters, ready to be started."""

    @property
    def name(self) -> str: ...

    @property
    def type(self) -> str:
        """As in YAML: ``effort_controllers/JointTrajectoryController``."""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it claims, in the order of its commands."""

    @property
    def interface(self) -> Interface | None:
        """The command interface it claims; None if it only reads."""

    @property
    def waits_for_command(self) -> bool:
        """Whether the brakes stay on from its start to its first command."""

    def start(self, indices: Sequence[int], state: JointState) -> Controller:
        """Return a running controller that holds the measured ``state``.

        Args:
            indices: Where its joints stand in the state's lists.
            state: The state at the instant of the start.
        """


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
