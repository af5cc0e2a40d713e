"""Finds the origins of arguments' values, and the uses of the arguments."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import final

from tool0.errors import SourceLocation
from tool0.lint.launch.explanation import Item
from tool0.lint.launch.model import (
    Argument,
    Entry,
    Include,
    LaunchFile,
    Node,
    Parameter,
    Place,
    Rosparam,
    Statement,
)
from tool0.lint.launch.xacro_files import XacroFile, xacro_call

MAX_VISITS = 300_000
"""Largest number of entries that are visited to find the uses of an argument.  A limit
is needed because the number of entries grows exponentially with nested includes."""
_ORIGINS = {
    "command line": "from the command line",
    "include": "given by the include",
    "pass_all_args": "passed on by the include",
    "value": "fixed",
    "default": "the default",
    "missing": "required, and not given",
    "switched off": "switched off",
}

_FROM_OUTSIDE = ("include", "pass_all_args")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class _Use:
    """One place in a launch file that uses arguments."""

    what: str
    """Display name, such as ``args of node /spawner``."""
    names: Sequence[str]
    """Names of the arguments that are used in this place."""
    location: SourceLocation
    is_off: bool = False
    argument: tuple[LaunchFile, str] | None = None
    """The argument of this file or of an included file whose value contains the
    arguments in ``names``."""
    xacro: tuple[Parameter, str] | None = None
    """The argument of xacro whose value contains the arguments in ``names``."""


@final
@dataclass(frozen=True, slots=True)
class _Part:
    """Any part of a launch file that may use arguments or may depend on a condition."""

    what: str
    place: Place
    uses: tuple[_Use, ...]
    argument: str = ""
    """Name of the argument that this part declares; empty if it declares none."""


def _uses(launch: LaunchFile) -> list[_Use]:
    """Return all uses of the arguments of ``launch``, in file order."""
    parts = list(_parts(launch))
    found = [use for part in parts for use in part.uses]
    found += _conditions(launch, parts)
    return sorted(found, key=lambda use: use.location.line or 0)


def _parts(launch: LaunchFile) -> Iterator[_Part]:
    for argument in launch.arguments:
        what, place, value = f"argument {argument.name}", argument.place, argument.value
        names = () if value is None else value.uses
        if argument.origin not in ("value", "default"):
            names = ()
        use = _use(what, names, place, argument=(launch, argument.name))
        yield _Part(what, place, (use,), argument.name)
    for entry in launch.entries:
        if isinstance(entry, Include):
            yield from _of_include(entry)
        yield _Part(describe(entry), entry.place, tuple(_of_entry(entry)))
        for part in entry.parts if isinstance(entry, Node) else ():
            of = describe(part)
            if not (isinstance(part, Parameter) and part.full_name):
                of = f"{of} of {describe(entry)}"
            is_inherited = part.place.location.file != entry.place.location.file
            texts = () if is_inherited else part.texts
            uses = [_use(f"{k} of {of}", text.uses, part.place) for k, text in texts]
            yield _Part(describe(part), part.place, tuple(uses))


def _of_entry(entry: Entry) -> Iterator[_Use]:
    """Yield the uses in an entry's texts.

    For a xacro command, one use is yielded for each argument of xacro.
    """
    call = xacro_call(entry) if isinstance(entry, Parameter) else None
    in_xacro: set[str] = set()
    if call is not None and isinstance(entry, Parameter):
        of = describe(entry) if call.file is None else call.file.name
        for argument, names in call.uses.items():
            in_xacro.update(names)
            what = f"xacro argument {argument} of {of}"
            yield _use(what, names, entry.place, xacro=(entry, argument))
    for key, text in entry.texts:
        others = [n for n in text.uses if key != "command" or n not in in_xacro]
        yield _use(f"{key} of {describe(entry)}", others, entry.place)


def _of_include(include: Include) -> Iterator[_Part]:
    """Yield the uses of values that are passed as arguments to the included file."""
    child, of = include.launch, _included(include)
    # the include's conditions come first
    yield _Part(describe(include), include.place, ())
    for item in include.passed:
        is_known = child is not None and child.argument(item.name) is not None
        use = _use(
            f"argument {item.name} of {of}",
            () if item.value is None else item.value.uses,
            item.place,
            argument=(child, item.name) if child and is_known else None,
        )
        yield _Part(f"argument {item.name}", item.place, (use,))
    if include.passes_all and child is not None:
        passed = {p.name for p in include.passed if p.place.holds is not False}
        passed_on = dict.fromkeys(a.name for a in child.arguments)
        uses = [
            _use(f"argument {n} of {of}", (n,), include.place, argument=(child, n))
            for n in passed_on
            if n not in passed and _origin(child, n) == "pass_all_args"
        ]
        yield _Part(describe(include), include.place, tuple(uses))


def _origin(launch: LaunchFile, name: str) -> str:
    argument = launch.argument(name)
    return "" if argument is None else argument.origin


def _conditions(launch: LaunchFile, parts: list[_Part]) -> Iterator[_Use]:
    """Yield each ``if`` and ``unless`` once, even if it applies to a group."""
    seen = set()
    for part in parts:
        for number, condition in enumerate(reversed(part.place.conditions)):
            where = condition.text.location
            key = (condition.kind, where)
            if where.file != launch.file or key in seen:
                continue
            seen.add(key)
            is_own = number == 0 and where == part.place.location
            goes_on = is_own and part.argument and part.place.holds is not False
            yield _Use(
                what=f"{condition.kind} of {part.what if is_own else 'the group'}",
                names=condition.text.uses,
                location=where,
                argument=(launch, part.argument) if goes_on else None,
            )


def _use(
    what: str,
    names: Sequence[str],
    place: Place,
    *,
    argument: tuple[LaunchFile, str] | None = None,
    xacro: tuple[Parameter, str] | None = None,
) -> _Use:
    return _Use(
        what=what,
        names=names,
        location=place.location,
        is_off=place.holds is False,
        argument=argument,
        xacro=xacro,
    )


def describe(entry: Entry) -> str:
    """Return the display name of an entry."""
    match entry:
        case Node():
            kind = "test" if entry.is_test else "node"
            return f"{kind} {entry.full_name or entry.name.raw}"
        case Parameter():
            return f"param {entry.full_name or entry.name.resolved or entry.name.raw}"
        case Rosparam():
            return f"rosparam {entry.command}"
        case Include():
            return f"include {_included(entry)}"
        case Statement(kind="machine"):
            return "machine"
        case Statement():
            return f"{entry.kind} {entry.subject.resolved or entry.subject.raw}"


def _included(include: Include) -> str:
    return include.file.raw if include.path is None else include.path.name


def argument_flow(
    launch: LaunchFile, robots: Mapping[Parameter, XacroFile]
) -> tuple[Item, ...]:
    """Return an item for each file that has arguments, with their uses in the file.

    For an included file, the item lists only arguments whose values do not come from an
    argument of another file.  Every other argument is listed below the argument from
    which its value comes.

    Args:
        launch: The launch file.
        robots: The xacro files that the launch file's parameters load
            (``xacro_robots``).
    """
    explainer = _FlowExplainer(launch, robots)
    listed = [explainer.arguments(file) for file in launch.files()]
    return tuple(item for item in listed if item.items)


@final
class _FlowExplainer:
    """Follows the arguments of one file and of the files that it includes."""

    def __init__(
        self, launch: LaunchFile, robots: Mapping[Parameter, XacroFile]
    ) -> None:
        self._launch = launch
        self._robots = robots
        self._left = MAX_VISITS
        self._uses_in: dict[int, list[_Use]] = {}

    def arguments(self, launch: LaunchFile) -> Item:
        """Return an item with the arguments that are listed for one file."""
        is_root = launch is self._launch
        names = [argument.name for argument in launch.arguments]
        found = []
        for argument in launch.arguments:
            is_only = names.count(argument.name) == 1
            is_listed = is_only or argument.origin != "switched off"
            uses = () if argument.value is None else argument.value.uses
            comes = argument.origin in _FROM_OUTSIDE and uses
            if is_listed and (is_root or not comes):
                found.append(self._argument(launch, argument))
        return Item(
            kind="launch",
            name=str(launch.file),
            location=SourceLocation(launch.file),
            items=tuple(found),
        )

    def _argument(self, launch: LaunchFile, argument: Argument) -> Item:
        value = argument.value
        items = tuple(self._uses(launch, argument.name, ()))
        reason = "" if value is None else value.reason
        is_outside = value is not None and argument.origin in _FROM_OUTSIDE
        place = value.location if value and is_outside else argument.place.location
        notes = [_ORIGINS[argument.origin], reason, "" if items else "nothing uses it"]
        return Item(
            kind="argument",
            name=argument.name,
            value=None if value is None else value.resolved,
            location=place,
            note="; ".join(note for note in notes if note),
            items=items,
        )

    def _uses(
        self, launch: LaunchFile, name: str, path: tuple[tuple[int, str], ...]
    ) -> Iterator[Item]:
        """Yield the uses of an argument, including uses through other arguments."""
        here = (id(launch), name)
        if here in path:
            return
        self._left -= len(launch.entries) + len(launch.arguments) + 1
        if self._left < 0:
            where = SourceLocation(launch.file)
            yield Item(kind="use", name="more than can be listed", location=where)
            return
        if id(launch) not in self._uses_in:
            self._uses_in[id(launch)] = _uses(launch)
        for use in self._uses_in[id(launch)]:
            if name not in use.names:
                continue
            items: tuple[Item, ...] = ()
            if use.argument is not None:
                items = tuple(self._uses(*use.argument, (*path, here)))
            elif use.xacro is not None:
                items = tuple(self._in_xacro(*use.xacro))
            yield Item(
                kind="use",
                name=use.what,
                location=use.location,
                note="switched off" if use.is_off else "",
                items=items,
            )

    def _in_xacro(self, parameter: Parameter, name: str) -> Iterator[Item]:
        robot = self._robots.get(parameter)
        seen = set()
        for file in () if robot is None else robot.walk():
            for place in file.uses:
                if place.argument == name and place not in seen:
                    seen.add(place)
                    attribute = f"{place.attribute} of " if place.attribute else ""
                    yield Item(
                        kind="use",
                        name=f"{attribute}<{place.element}>",
                        location=place.location,
                    )
