"""ros_control YAML, parsed once into the specs of controllers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import final

from tool0.control.controller_types import ControllerSpec, parser_of
from tool0.control.parameters import RobotJoints
from tool0.description.model import JointLimits
from tool0.description.yaml_tree import Tree, read_files
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, SourceLocation, did_you_mean

NOT_ENFORCED = ("max_acceleration", "max_jerk")
"""Limits that ROS knows and no drive here enforces."""
_SAMPLE_LIMITS = """
{has_position_limits: true, min_position: 0, max_position: 0,
 has_velocity_limits: true, max_velocity: 1, has_effort_limits: true, max_effort: 1}
"""
"""A joint with every limit, for ``joint_limit_parameters``."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class LimitOverrides:
    """Limits that ``joint_limits/<joint>`` puts in place of the URDF's.

    None leaves the URDF's.
    """

    position: tuple[float, float] | None = None
    velocity: float | None = None
    effort: float | None = None

    def over(self, limits: JointLimits) -> JointLimits:
        """Return ``limits`` with these put in their place."""
        lower, upper = self.position or (limits.lower, limits.upper)
        return JointLimits(
            lower=lower,
            upper=upper,
            velocity=limits.velocity if self.velocity is None else self.velocity,
            effort=limits.effort if self.effort is None else self.effort,
        )


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
        """Return the controllers of a YAML text.

        Args:
            text: The YAML.
            location: Where its first line stands, for messages.
        """
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
        """Return everything that the files say, as plain values by name."""
        return {name: e.plain() for name, e in self.tree.root.children.items()}

    def spec(self, name: str, robot: RobotJoints) -> ControllerSpec:
        """Return the checked parameters of a controller.

        Raises:
            ConfigError: If it is not there, or anything about it is wrong.
        """
        parameters = self._namespace(name)
        type_entry = parameters.find("type")
        if type_entry is None:
            raise ConfigError(
                f"Could not load controller '{name}' because its type was not "
                f"specified; '{name}' needs a 'type'",
                parameters.location,
            )
        parse = parser_of(parameters.text("type"), type_entry.location)
        return parse(parameters, robot)

    def _namespace(self, name: str) -> Namespace:
        entry = self.tree.root.children.get(name)
        if entry is None:
            raise ConfigError(
                f"unknown controller '{name}'{did_you_mean(name, self.names)}"
            )
        if not entry.is_mapping:
            raise ConfigError(
                f"'{name}' is no controller, but {entry.describe()}", entry.location
            )
        return Namespace(entry)

    def joint_limits(self) -> Mapping[str, LimitOverrides]:
        """Return the limits that ``joint_limits`` puts over the URDF's, by joint."""
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


def _limits(limits: Namespace) -> LimitOverrides:
    """Read one joint's limits: each counts beside ``has_…: true``, as in ROS."""
    limits.accept(*NOT_ENFORCED, "has_acceleration_limits", "has_jerk_limits")
    limits.accept("angle_wraparound")

    def has_limit(kind: str) -> bool | None:
        flag = f"has_{kind}_limits"
        return None if limits.find(flag) is None else limits.boolean(flag, default=True)

    def largest(kind: str) -> float | None:
        has = has_limit(kind)
        if has is None:
            return None
        return limits.not_negative(f"max_{kind}") if has else math.inf

    position: tuple[float, float] | None = None
    if has_limit("position") is False:
        position = (-math.inf, math.inf)
    elif has_limit("position"):
        position = (limits.number("min_position"), limits.number("max_position"))
        if not position[0] <= position[1]:
            raise ConfigError(
                f"'{limits.entry.key}' has min_position {position[0]} "
                f"above max_position {position[1]}",
                limits.location,
            )
    return LimitOverrides(
        position=position,
        velocity=largest("velocity"),
        effort=largest("effort"),
    )
