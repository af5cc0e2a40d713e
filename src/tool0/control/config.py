"""ros_control's controllers: their interface, their types, and their YAML."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Protocol, final

from tool0.control.law import Law
from tool0.control.parameters import Gains, Pid, RobotJoints
from tool0.control.trajectory import Setpoint
from tool0.description.model import Interface
from tool0.description.yaml_tree import Tree, read_files
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, SourceLocation, did_you_mean
from tool0.hardware.engine import JointState


class Controller(Protocol):
    """A running controller: if it exists, it is ready; stopping drops it."""

    @property
    def pid(self) -> Pid | None:
        """The PID that turns errors into commands; None if commands are passed on."""

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return a command per claimed joint, in the order of the spec's joints.

        Args:
            state: Every joint, in the engine's order.
            period: Time since the last update [s].
        """

    def law(self) -> Law | None:
        """Return what ``update`` does until an event; None if only it can tell."""

    def observe(self, state: JointState) -> None:
        """Note the state of the last tick, which was executed by its law."""

    def setpoint(self) -> Setpoint | None:
        """Return the setpoints of the joints; None if positions are not commanded.

        It is called between ticks, about a hundred times a second, so it only keeps
        references to immutable values.
        """

    def stop(self) -> None:
        """End the motion in progress: an active goal is PREEMPTED."""


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
    def gains(self) -> tuple[Gains, ...]:
        """One per joint; none without a PID."""

    @property
    def waits_for_command(self) -> bool:
        """Whether the brakes stay on from its start to its first command."""

    def start(self, indices: Sequence[int], state: JointState) -> Controller:
        """Return a running controller that holds the measured ``state``.

        Args:
            indices: Indices of its joints in the state's lists.
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

    They are recorded while the type's parser reads a sample, so that a new parameter
    is added in the parser alone.

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


_SAMPLE_LIMITS = """
{has_position_limits: true, min_position: 0, max_position: 0,
 has_velocity_limits: true, max_velocity: 1, has_effort_limits: true, max_effort: 1,
 has_acceleration_limits: true, max_acceleration: 1,
 has_jerk_limits: true, max_jerk: 1}
"""
"""A joint with every limit, for ``joint_limit_parameters``."""


@final
class ControllerConfig:
    """The controllers that YAML files describe; each is checked when it is loaded."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree

    @staticmethod
    def from_files(files: Path | Iterable[Path]) -> ControllerConfig:
        """Return the controllers of one file or several; later ones override.

        Raises:
            ConfigError: If a file cannot be read or is not YAML.
        """
        paths = [files] if isinstance(files, Path) else list(files)
        return ControllerConfig(read_files(paths))

    @staticmethod
    def from_text(
        text: str, location: SourceLocation | None = None
    ) -> ControllerConfig:
        """Return the controllers of a YAML text, which begins at ``location``."""
        tree = Tree()
        tree.load(text, location or SourceLocation(None, 1))
        return ControllerConfig(tree)

    @property
    def names(self) -> tuple[str, ...]:
        """The namespaces that have a ``type``: the controllers."""
        return tuple(self.types)

    @property
    def types(self) -> Mapping[str, str]:
        """The type of each controller, as written, which need not exist."""
        return {
            name: str(entry.children["type"].scalar)
            for name, entry in self.tree.root.children.items()
            if "type" in entry.children
        }

    def parameters(self) -> Mapping[str, object]:
        """Return the whole content of the files, as plain values by name."""
        return {name: e.plain() for name, e in self.tree.root.children.items()}

    def spec(self, name: str, robot: RobotJoints) -> ControllerSpec:
        """Return the checked parameters of a controller.

        Raises:
            ConfigError: If it is missing, or its parameters are wrong.
        """
        entry = self.tree.root.children.get(name)
        if entry is None:
            raise ConfigError(
                f"unknown controller '{name}'{did_you_mean(name, self.names)}"
            )
        if not entry.is_mapping:
            raise ConfigError(
                f"'{name}' is no controller, but {entry.describe()}", entry.location
            )
        parameters = Namespace(entry)
        type_entry = parameters.find("type")
        if type_entry is None:
            raise ConfigError(
                f"Could not load controller '{name}' because its type was not "
                f"specified; '{name}' needs a 'type'",
                parameters.location,
            )
        parse = parser_of(parameters.text("type"), type_entry.location)
        return parse(parameters, robot)

    def joint_limits(self) -> Mapping[str, Mapping[str, float]]:
        """Return the limits in ``joint_limits`` that replace the URDF's, by joint.

        The keys are fields of ``JointLimits``.
        """
        limits = Namespace(self.tree.root).namespace("joint_limits")
        entries = {} if limits is None else limits.entry.children
        return {name: _limits(Namespace(entry)) for name, entry in entries.items()}


@cache
def joint_limit_parameters() -> frozenset[str]:
    """Return the parameters that are known under ``joint_limits/<joint>``."""
    tree = Tree()
    tree.load(_SAMPLE_LIMITS, SourceLocation(None, 1))
    sample = Namespace(tree.root)
    _limits(sample)
    return sample.read_keys()


def _limits(limits: Namespace) -> dict[str, float]:
    """Read one joint's limits: each applies only with ``has_…: true``, as in ROS."""
    limits.accept("angle_wraparound")

    def has_limit(kind: str) -> bool | None:
        flag = f"has_{kind}_limits"
        return None if limits.find(flag) is None else limits.boolean(flag, default=True)

    found: dict[str, float] = {}
    if has_limit("position") is False:
        found = {"lower": -math.inf, "upper": math.inf}
    elif has_limit("position"):
        lower, upper = limits.number("min_position"), limits.number("max_position")
        if not lower <= upper:
            raise ConfigError(
                f"'{limits.entry.key}' has min_position {lower} "
                f"above max_position {upper}",
                limits.location,
            )
        found = {"lower": lower, "upper": upper}
    for kind in ("velocity", "acceleration", "jerk", "effort"):
        has = has_limit(kind)
        if has is not None:
            found[kind] = limits.not_negative(f"max_{kind}") if has else math.inf
    return found
