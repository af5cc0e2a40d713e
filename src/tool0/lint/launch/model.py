"""The content of a launch file as values: arguments, nodes, parameters, includes.

Every entry has a ``place`` and ``texts``.  ``texts`` contains each attribute that may
contain an argument, with the attribute's display name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias, final

from tool0.description.finding import Finding
from tool0.errors import SourceLocation

Origin: TypeAlias = Literal[
    "command line",
    "include",
    "pass_all_args",
    "value",
    "default",
    "missing",
    "switched off",
]
"""Origin of an argument's value.  ``value`` marks a value that cannot be overridden."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    """An attribute's value, or the text of an element."""

    raw: str
    """Text as it is written in the file."""
    resolved: str | None
    """Text in which every ``$(…)`` is replaced by its value; None if one of the values
    is unknown."""
    location: SourceLocation
    uses: tuple[str, ...] = ()
    """Names of the arguments in the text, without duplicates.  The arguments are those
    of the file in which the text is written."""
    reason: str = ""
    """Reason why the text is not resolved; empty if it is resolved."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """An ``if`` or ``unless`` attribute."""

    kind: Literal["if", "unless"]
    text: Text
    holds: bool | None
    """Whether the condition makes the element active; None if this is unknown."""


def all_hold(conditions: Iterable[Condition]) -> bool | None:
    """Return whether an element under these conditions is active; None if unknown."""
    held = [condition.holds for condition in conditions]
    return False if False in held else None if None in held else True


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Location of an element, its namespace and its conditions."""

    location: SourceLocation
    namespace: str | None
    """Global namespace, with a trailing slash; None if it cannot be resolved."""
    conditions: tuple[Condition, ...] = ()
    """Conditions of this element and of all elements around it, with the outermost
    first."""

    @property
    def holds(self) -> bool | None:
        """Whether roslaunch would process the element.

        The result is None if it depends on an argument without a value.
        """
        return all_hold(self.conditions)


NamedText: TypeAlias = tuple[str, Text]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Argument:
    """An argument that is declared with ``<arg>``, and its value."""

    name: str
    place: Place
    value: Text | None = None
    """Value of the argument; None if it has no value.  The text's location is the place
    where the value is given, and the text uses arguments of the file at that place."""
    origin: Origin
    default: Text | None = None
    """Default value in the declaration.  The default may differ from the value."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """A ``<remap>``, ``<env>`` or ``<machine>``, which has only attributes.

    In ROS 2, a statement can also be a process that is not a node.
    """

    kind: Literal["remap", "env", "machine", "process"]
    place: Place
    texts: tuple[NamedText, ...]
    """Attributes of the statement: ``from`` and ``to`` for a remap, ``name`` and
    ``value`` for an env, and ``name`` and ``cmd`` for a process."""

    @property
    def subject(self) -> Text:
        """First attribute: the remapped name, or the name of the variable."""
        return self.texts[0][1]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """A ``<param>``."""

    place: Place
    name: Text
    full_name: str | None
    """Full name, such as ``/robot_description``.  The name is None if it is unknown, or
    if it is private and the parameter is not in a node."""
    type: str = "auto"
    source: Literal["value", "textfile", "binfile", "command"]
    content: Text
    """Text of the value, of the file's path, or of the command."""
    words: tuple[str, ...] = ()
    """Words of the command, split as by a shell; empty if there is no command, or if it
    is unresolved."""

    @property
    def texts(self) -> tuple[NamedText, ...]:
        return (("name", self.name), (self.source, self.content))

    @property
    def is_private(self) -> bool:
        """Whether the name starts with a tilde, so that it applies to later nodes."""
        return (self.name.resolved or self.name.raw).startswith("~")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Rosparam:
    """A ``<rosparam>``, with a YAML file or with YAML in the launch file."""

    place: Place
    command: Literal["load", "delete", "dump"]
    namespace: str | None
    """Full name under which the parameters are set; None if it is unknown."""
    file: Text | None
    path: Path | None
    """Path of the file; None if it is unknown.  The file need not exist."""
    yaml: Text | None
    """Loaded YAML; None if the file cannot be read.  Arguments in the YAML are replaced
    if ``subst_value`` is set.  The text's location is the location of the YAML's first
    line."""
    names: tuple[NamedText, ...] = ()
    """The attributes ``ns`` and ``param``, if they are given."""

    @property
    def texts(self) -> tuple[NamedText, ...]:
        optional = (("file", self.file), ("yaml", self.yaml))
        return tuple((key, text) for key, text in optional if text) + self.names


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """A ``<node>`` or a ``<test>``."""

    place: Place
    is_test: bool
    package: Text
    type: Text
    name: Text
    full_name: str | None
    args: Text | None
    words: tuple[str, ...]
    """Arguments of the node, split as by a shell; empty if they are unresolved."""
    settings: tuple[NamedText, ...] = ()
    """All other attributes, such as ``output`` and ``respawn``."""
    parameters: tuple[Parameter, ...] = ()
    """Parameters of the node, including private parameters that are set before the node
    in the file."""
    rosparams: tuple[Rosparam, ...] = ()
    remaps: tuple[Statement, ...] = ()
    """Remaps that apply to the node.  Remaps inside the node's element come last."""
    environment: tuple[Statement, ...] = ()

    @property
    def texts(self) -> tuple[NamedText, ...]:
        texts = [("pkg", self.package), ("type", self.type), ("name", self.name)]
        if self.args is not None:
            texts.append(("args", self.args))
        return (*texts, *self.settings)

    @property
    def parts(self) -> tuple[Entry, ...]:
        """All elements inside the node."""
        return (*self.parameters, *self.rosparams, *self.remaps, *self.environment)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Passed:
    """An ``<arg>`` in an ``<include>``."""

    name: str
    place: Place
    value: Text | None


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Include:
    """An ``<include>``."""

    place: Place
    file: Text
    path: Path | None
    passed: tuple[Passed, ...] = ()
    passes_all: bool = False
    settings: tuple[NamedText, ...] = ()
    launch: LaunchFile | None = None
    reason: str = ""
    """Reason why ``launch`` is None; empty otherwise."""

    @property
    def texts(self) -> tuple[NamedText, ...]:
        return (("file", self.file), *self.settings)


Entry: TypeAlias = Statement | Parameter | Rosparam | Node | Include


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchFile:
    """A launch file that is read with certain arguments in a certain namespace."""

    file: Path
    arguments: tuple[Argument, ...] = ()
    entries: tuple[Entry, ...] = ()
    """Entries in file order.  Each group is replaced by its entries."""
    findings: tuple[Finding, ...] = ()
    """Findings in this file and in the files that it includes."""
    notes: tuple[str, ...] = ()
    """Parts of this file or of an included file that could not be analyzed."""

    @property
    def is_python(self) -> bool:
        """Whether this is a launch file of ROS 2."""
        return self.file.suffix == ".py"

    def walk(self, *, active_only: bool = True) -> Iterator[Entry]:
        """Yield the entries in the order in which roslaunch processes them.

        An include comes before the entries of the included file.  Elements that depend
        on an argument without a value are treated as active.
        """
        for entry in self.entries:
            if active_only and entry.place.holds is False:
                continue
            yield entry
            if isinstance(entry, Include) and entry.launch is not None:
                yield from entry.launch.walk(active_only=active_only)

    def files(self) -> Iterator[LaunchFile]:
        """Yield this file and all files that it includes."""
        yield self
        for entry in self.walk():
            if isinstance(entry, Include) and entry.launch is not None:
                yield entry.launch

    def nodes(self) -> Iterator[Node]:
        """Yield every node and test."""
        return (entry for entry in self.walk() if isinstance(entry, Node))

    def parameters(self, *, active_only: bool = True) -> Iterator[Parameter]:
        """Yield every parameter, including parameters in nodes."""
        settings = self.settings(active_only=active_only)
        return (item for item in settings if isinstance(item, Parameter))

    def rosparams(self) -> Iterator[Rosparam]:
        """Yield every ``<rosparam>``, including elements in nodes."""
        return (item for item in self.settings() if isinstance(item, Rosparam))

    def settings(self, *, active_only: bool = True) -> Iterator[Parameter | Rosparam]:
        """Yield the elements that set parameters, in roslaunch's processing order."""
        for entry in self.walk(active_only=active_only):
            inner: tuple[Entry, ...] = (entry,)
            if isinstance(entry, Node):
                inner = (*entry.rosparams, *entry.parameters)
            for item in inner:
                is_wanted = not (active_only and item.place.holds is False)
                if is_wanted and isinstance(item, Parameter | Rosparam):
                    yield item

    def argument(self, name: str) -> Argument | None:
        """Return the argument named ``name``, preferably one with a value."""
        found = [argument for argument in self.arguments if argument.name == name]
        valued = [argument for argument in found if argument.value is not None]
        return next(iter(valued or found), None)
