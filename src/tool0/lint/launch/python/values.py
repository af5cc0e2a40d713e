"""The types of the values of an interpreted launch file.

All other values are plain Python values: None, bool, int, float, str, Path, list, tuple
or dict.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import TypeAlias, final

from tool0.errors import SourceLocation

Value: TypeAlias = object


@final
@dataclass(frozen=True, slots=True, eq=False)
class Unknown:
    """A value that can be determined only by executing the file."""

    reason: str


@final
@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """A value that may be any of several values, depending on an unknown condition."""

    values: tuple[Value, ...]


@final
@dataclass(frozen=True, slots=True)
class Name:
    """A module or a name in a module, such as ``launch.actions.GroupAction``."""

    dotted: str

    @property
    def last(self) -> str:
        return self.dotted.rpartition(".")[2]

    @property
    def is_of_launch(self) -> bool:
        """Whether the name is defined in launch or launch_ros."""
        return self.dotted.partition(".")[0] in ("launch", "launch_ros")


@final
@dataclass(slots=True, eq=False)
class Made:
    """An object of launch or launch_ros, represented by the call that creates it."""

    name: str
    """Class of the object."""
    location: SourceLocation
    arguments: Mapping[str, Value] = field(default_factory=dict)
    """Arguments of the call by name, including positional arguments."""
    places: Mapping[str, SourceLocation] = field(default_factory=dict)
    """Location of each argument."""

    def get(self, name: str) -> Value:
        """Return the value of an argument; None if the argument is not given."""
        return self.arguments.get(name)

    def place(self, name: str) -> SourceLocation:
        """Return the location of an argument, or of the call if it is not given."""
        return self.places.get(name, self.location)


@final
@dataclass(slots=True)
class Scope:
    """Variables of a module or of one function call."""

    outer: Scope | None = None
    names: dict[str, Value] = field(default_factory=dict)

    def find(self, name: str) -> Scope | None:
        """Return the innermost scope that contains the name."""
        if name in self.names:
            return self
        return None if self.outer is None else self.outer.find(name)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Function:
    """A function that the file defines."""

    node: ast.FunctionDef | ast.Lambda
    scope: Scope


@final
@dataclass(frozen=True, slots=True, eq=False)
class Method:
    """A method of a value."""

    owner: Value
    name: str


def is_text(value: Value) -> bool:
    """Return whether a value is a plain text or a path."""
    return isinstance(value, str | PurePath)


def truth(value: Value) -> bool | None:
    """Return whether Python treats a value as true; None if this is unknown."""
    if isinstance(value, Unknown | Choice):
        return None
    if isinstance(value, Made | Name | Function | Method):
        return True
    return bool(value)


def same(first: Value, second: Value) -> bool:
    """Return whether two values are certainly equal."""
    if first is second:
        return True
    plain = (bool, int, float, str, PurePath)
    return isinstance(first, plain) and type(first) is type(second) and first == second
