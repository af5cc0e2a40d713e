"""Reading typed values out of a controller's namespace."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import final

from tool0.control.pid import Gains
from tool0.control.yaml_tree import Entry
from tool0.description.model import Interface, Joint
from tool0.errors import ConfigError, SourceLocation, nearest_name

INTERFACE_OF_PACKAGE = {
    "effort_controllers": Interface.EFFORT,
    "position_controllers": Interface.POSITION,
    "velocity_controllers": Interface.VELOCITY,
}
"""The command interface that a controller type's package stands for."""


@final
@dataclass(frozen=True, slots=True)
class Robot:
    """What a controller's parameters are checked against."""

    joints: Mapping[str, Joint]
    interfaces: Mapping[str, Interface]
    """The joints with a transmission, in the engine's order."""


@final
@dataclass(frozen=True, slots=True)
class Namespace:
    """A mapping of parameters; every getter raises ConfigError with file and line."""

    entry: Entry

    @property
    def location(self) -> SourceLocation:
        return self.entry.location

    @property
    def name(self) -> str:
        """The last part of its key: for a controller, its name."""
        return self.entry.key.rpartition("/")[2]

    def find(self, path: str) -> Entry | None:
        """Return what stands at ``a/b``, or None."""
        entry: Entry | None = self.entry
        for part in path.split("/"):
            if entry is None or entry.children is None:
                return None
            entry = entry.children.get(part)
        return entry

    def namespace(self, path: str) -> Namespace | None:
        """Return the mapping at ``path``, or None if there is nothing."""
        entry = self.find(path)
        if entry is None:
            return None
        if entry.children is None:
            raise _wrong(entry, "a mapping")
        return Namespace(entry)

    def names(self) -> Iterator[str]:
        """Yield the keys."""
        yield from self.entry.children or ()

    def number(self, path: str, default: float | None = None) -> float:
        """Return the finite number at ``path``."""
        entry = self.find(path)
        if entry is None:
            if default is None:
                raise self.missing(path, "a number")
            return default
        value = entry.scalar
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise _wrong(entry, "a number")
        if not math.isfinite(value):
            raise _wrong(entry, "a finite number")
        return float(value)

    def not_negative(self, path: str, default: float | None = None) -> float:
        """Return the number at ``path``, 0 or more."""
        value = self.number(path, default)
        entry = self.find(path)
        if entry is not None and not value >= 0.0:
            raise _wrong(entry, "0 or more")
        return value

    def boolean(self, path: str, default: bool) -> bool:
        entry = self.find(path)
        if entry is None:
            return default
        if not isinstance(entry.scalar, bool):
            raise _wrong(entry, "true or false")
        return entry.scalar

    def text(self, path: str) -> str:
        entry = self.find(path)
        if entry is None:
            raise self.missing(path, "a text")
        if not isinstance(entry.scalar, str):
            raise _wrong(entry, "a text")
        return entry.scalar

    def texts(self, path: str) -> tuple[str, ...]:
        """Return the list of texts at ``path``, with at least one element."""
        entry = self.find(path)
        if entry is None:
            raise self.missing(path, "a list of names")
        texts = tuple(
            item.scalar for item in entry.items or () if isinstance(item.scalar, str)
        )
        if not texts or len(texts) != len(entry.items or ()):
            raise _wrong(entry, "a list of names, like [joint_1, joint_2]")
        return texts

    def missing(self, path: str, kind: str) -> ConfigError:
        """Return the error that ``path`` must be there."""
        near = nearest_name(path, list(self.names())) if list(self.names()) else ""
        hint = near if near.startswith("; did") else ""
        return ConfigError(
            f"'{self.entry.key}' lacks '{path}', {kind}{hint}", self.location
        )


def controlled_joint(
    robot: Robot, name: str, interface: Interface | None, entry: Entry
) -> Joint:
    """Return the joint called ``name``, if a controller may command it.

    Args:
        robot: Where the joint must be.
        name: The joint.
        interface: What it must take; None for any.
        entry: Where a file names it, for messages.
    """
    joint = robot.joints.get(name)
    wanted = "any interface" if interface is None else f"'{interface.value}'"
    if joint is None:
        raise ConfigError(
            f"Could not find joint '{name}' in {wanted}: the robot has no such joint"
            + nearest_name(name, list(robot.interfaces)),
            entry.location,
        )
    has = robot.interfaces.get(name)
    if has is None:
        why = f" and follows '{joint.mimic.joint}'" if joint.mimic is not None else ""
        raise ConfigError(
            f"Could not find joint '{name}' in {wanted}: it has no <transmission>{why}"
            f"; joints with one: {', '.join(robot.interfaces) or '(none)'}",
            entry.location,
        )
    if interface is not None and has is not interface:
        raise ConfigError(
            f"Could not find joint '{name}' in {wanted}: "
            f"its <transmission> offers '{has.value}'",
            entry.location,
        )
    return joint


def controlled_joints(
    robot: Robot, parameters: Namespace, interface: Interface
) -> tuple[Joint, ...]:
    """Return the joints of the list ``joints``, each of them named once."""
    names = parameters.texts("joints")
    entry = parameters.find("joints")
    items = (entry.items if entry is not None else None) or []
    for name, item in zip(names, items, strict=True):
        if names.count(name) > 1:
            raise ConfigError(f"'{item.key}' names joint '{name}' twice", item.location)
    return tuple(
        controlled_joint(robot, name, interface, item)
        for name, item in zip(names, items, strict=True)
    )


def single_joint(robot: Robot, parameters: Namespace, interface: Interface) -> Joint:
    """Return the joint that ``joint`` names."""
    name = parameters.text("joint")
    entry = parameters.find("joint") or parameters.entry
    return controlled_joint(robot, name, interface, entry)


def read_gains(parameters: Namespace, path: str, why: str) -> Gains:
    """Return the gains at ``path``; ``p`` is required, as in control_toolbox.

    Args:
        parameters: The controller's.
        path: Such as ``gains/elbow_joint``.
        why: Who needs them, for the message that they are missing.
    """
    gains = parameters.namespace(path)
    if gains is None:
        outer = parameters.find(path.rpartition("/")[0]) or parameters.entry
        present = list(outer.children or ())
        hint = nearest_name(path.rpartition("/")[2], present) if present else ""
        raise ConfigError(
            f"No p gain specified for pid: '{parameters.entry.key}' lacks "
            f"'{path}/p', which {why}" + (hint if hint.startswith("; did") else ""),
            outer.location,
        )
    if gains.find("p") is None:
        raise ConfigError(
            f"No p gain specified for pid: '{gains.entry.key}' lacks 'p', which {why}",
            gains.location,
        )
    clamp = abs(gains.number("i_clamp", 0.0))
    return Gains(
        p=gains.number("p"),
        i=gains.number("i", 0.0),
        d=gains.number("d", 0.0),
        i_min=-abs(gains.number("i_clamp_min", clamp)),
        i_max=abs(gains.number("i_clamp_max", clamp)),
        antiwindup=gains.boolean("antiwindup", default=False),
    )


def _wrong(entry: Entry, wanted: str) -> ConfigError:
    hint = ""
    text = entry.scalar
    if isinstance(text, str) and wanted == "a number":
        with contextlib.suppress(ValueError):
            hint = f"; YAML 1.1 writes that {float(text):.1e}"
    return ConfigError(
        f"'{entry.key}' must be {wanted}, got {entry.describe()}{hint}",
        entry.location,
    )
