"""The two versions of ros_control, which differ in controllers, YAML and terms."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Literal, NamedTuple, final

from tool0.control.controller import ControllerSpec
from tool0.control.parameters import RobotJoints
from tool0.description.finding import Finding
from tool0.description.yaml_tree import Tree, YamlEntry
from tool0.description.yaml_values import Namespace, Value
from tool0.errors import ConfigError, SourceLocation, did_you_mean
from tool0.protocol.controllers import Role

Parser = Callable[[str, str, Namespace, RobotJoints], ControllerSpec]
"""Parser of a controller's parameters.  The arguments are the controller's name, type
and YAML, and the robot's joints."""


class ControllerType(NamedTuple):
    """A type of controller."""

    role: Role
    module: str
    """The module that defines ``parse(name, type_name, parameters, robot)``."""


class Declared(NamedTuple):
    """A controller that is declared in YAML."""

    type: YamlEntry
    parameters: YamlEntry


class Stages(NamedTuple):
    """The names of the stages in a controller's life cycle."""

    unconfigured: str
    configured: str
    """Name of the stage of a controller that is ready but has never been started."""
    running: str
    stopped: str


@final
@dataclass(frozen=True, eq=False, kw_only=True)
class Dialect:
    """A version of ros_control: ros_control of ROS 1, or ros2_control of ROS 2."""

    name: Literal["ros1", "ros2"]
    title: str
    """Name that is used in messages, such as ``ROS 1``."""
    types: Mapping[str, ControllerType]
    declared: Callable[[YamlEntry], Mapping[str, Declared]]
    """Function that returns the controllers in a YAML tree, by name.  The types of the
    controllers need not exist."""
    parameters: Callable[[YamlEntry, str], YamlEntry | None]
    """Function that returns a controller's parameters from a YAML tree, given its name,
    even if its type is missing."""
    joint_limits: Callable[[YamlEntry], Namespace | None]
    """Function that returns the limits that override the limits of the URDF, by
    joint."""
    control_period: Callable[[YamlEntry], float | None]
    """Function that returns the time between updates that a YAML tree specifies [s]."""
    stages: Stages
    common: frozenset[str]
    """Names of the parameters that every controller has."""
    sample: str
    """YAML of a controller for the joint ``*``.  The YAML contains every parameter that
    any type requires, but no ``type``."""
    linter: str
    """The module that defines ``lint(tree, joints)``."""
    is_configured_when_loaded: bool
    restarts_by_switch: bool
    """Whether one switch may stop and restart the same controller."""
    needs_known_controller: bool
    """Whether a switch that lists only unknown controllers is an error even if the
    switch is not strict."""
    bases: Mapping[Role, str]
    """The base class that ``list_controller_types`` reports, by role."""

    def lint(self, tree: Tree, joints: Collection[str] | None) -> tuple[Finding, ...]:
        """Return findings about unused, ineffective and suspicious parameters."""
        findings: tuple[Finding, ...] = import_module(self.linter).lint(tree, joints)
        return findings

    def role(self, type_name: str) -> Role:
        """Return the role of a type, or ``Role.READER`` if there is no such type."""
        known = self.types.get(type_name)
        return Role.READER if known is None else known.role

    def parser_of(self, type_name: str, location: SourceLocation | None) -> Parser:
        """Return the function that reads the parameters of a type.

        Raises:
            ConfigError: If there is no such type.
        """
        known = self.types.get(type_name)
        if known is None:
            names = sorted(self.types)
            hint = did_you_mean(type_name, names)
            all_of = "" if hint.startswith("; valid") else f" (of {', '.join(names)})"
            raise ConfigError(
                f"unknown controller type '{type_name}'{hint}{all_of}", location
            )
        parse: Parser = import_module(known.module).parse
        return parse

    def parameters_of(self, type_name: str) -> frozenset[str]:
        """Return the parameters that a type reads; ``*`` stands for a joint.

        The parameters are recorded while the parser of the type reads a sample.  A new
        parameter therefore only has to be added to the parser.

        Raises:
            ConfigError: If there is no such type.
        """
        return _sample_of(self, type_name).read_keys()

    def values_of(self, type_name: str) -> Mapping[str, Value]:
        """Return the values of a type's parameters for the sample.

        A parameter that the sample does not contain has its default value.  ``*``
        stands for a joint.  The values show the type of each parameter.

        Raises:
            ConfigError: If there is no such type.
        """
        return _sample_of(self, type_name).read_values()

    def readers_of(self, parameter: str) -> tuple[str, ...]:
        """Return the names, without packages, of the types that read a parameter."""
        types = sorted(self.types)
        readers = {name for name in types if parameter in self.parameters_of(name)}
        return tuple(sorted({name.partition("/")[2] for name in readers}))


@cache
def _sample_of(dialect: Dialect, type_name: str) -> Namespace:
    tree = Tree()
    tree.load(dialect.sample, SourceLocation(None, 1))
    sample = Namespace(tree.root)
    parse = dialect.parser_of(type_name, None)
    parse("sample", type_name, sample, RobotJoints.assumed("*", type_name))
    return sample


def siblings(parameter: str, known: Iterable[str]) -> set[str]:
    """Return the names of known parameters at the same level as ``parameter``."""
    prefix = parameter[: parameter.rfind("/") + 1]
    return {
        name.removeprefix(prefix).partition("/")[0]
        for name in known
        if name.startswith(prefix)
    }
