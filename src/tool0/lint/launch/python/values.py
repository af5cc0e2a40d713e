"""The values of an interpreted launch file.

Besides these, a value is a plain one of Python: None, bool, int, float, str, Path,
list, tuple or dict.
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
    """A value that only executing the file would give."""

    reason: str


@final
@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """One of several values, or none of them: it depends on something unknown."""

    values: tuple[Value, ...]


@final
@dataclass(frozen=True, slots=True)
class Name:
    """A module, or a name in one: ``launch.actions.GroupAction``."""

    dotted: str

    @property
    def last(self) -> str:
        return self.dotted.rpartition(".")[2]

    @property
    def is_of_launch(self) -> bool:
        """Whether it belongs to launch or launch_ros."""
        return self.dotted.partition(".")[0] in ("launch", "launch_ros")


@final
@dataclass(slots=True, eq=False)
class Made:
    """An object of launch or launch_ros, as the call that makes it."""

    name: str
    """Class of the object."""
    location: SourceLocation
    arguments: Mapping[str, Value] = field(default_factory=dict)
    """Positional ones, too, by name."""
    places: Mapping[str, SourceLocation] = field(default_factory=dict)
    """Location of each argument."""

    def get(self, name: str) -> Value:
        """Return an argument; None if it is not given."""
        return self.arguments.get(name)

    def place(self, name: str) -> SourceLocation:
        """Return where an argument stands, or else the call."""
        return self.places.get(name, self.location)


@final
@dataclass(slots=True)
class Scope:
    """The variables of a module or of one call of a function."""

    outer: Scope | None = None
    names: dict[str, Value] = field(default_factory=dict)

    def find(self, name: str) -> Scope | None:
        """Return the innermost scope that has the name."""
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
    """Whether a value is a plain text or path."""
    return isinstance(value, str | PurePath)


def truth(value: Value) -> bool | None:
    """Return whether a value counts as true; None if that is unknown."""
    if isinstance(value, Unknown | Choice):
        return None
    if isinstance(value, Made | Name | Function | Method):
        return True
    return bool(value)


def same(first: Value, second: Value) -> bool:
    """Whether two values are known to be equal."""
    if first is second:
        return True
    plain = (bool, int, float, str, PurePath)
    return isinstance(first, plain) and type(first) is type(second) and first == second
