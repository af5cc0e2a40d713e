"""Where the values of arguments come from, and where they end up."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import final

from tool0.errors import SourceLocation
from tool0.lint.launch.explanation import Item
from tool0.lint.launch.model import (
    Activity,
    Argument,
    Entry,
    Environment,
    Include,
    LaunchFile,
    Node,
    Parameter,
    Place,
    Remap,
    RemoteMachine,
    Rosparam,
)
from tool0.lint.launch.xacro_files import XacroFile, xacro_call

_OFF = Activity.INACTIVE
MAX_VISITS = 300_000
"""At entries, in search of what uses an argument: files may include files without
number."""
_ORIGINS = {
    "command line": "from the command line",
    "include": "given by the include",
    "pass_all_args": "passed on by the include",
    "value": "fixed",
    "default": "the default",
    "missing": "required, and not given",
    "switched off": "switched off",
}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ArgumentUse:
    """One place that uses an argument of a launch file."""

    what: str
    """For people: ``args of node /spawner``."""
    location: SourceLocation
    activity: Activity
    argument: tuple[LaunchFile, str] | None = None
    """The argument that it becomes a part of, of this file or of an included one."""
    xacro: tuple[Parameter, str] | None = None
    """The argument of xacro that it becomes a part of."""


def uses(launch: LaunchFile, name: str) -> Iterator[ArgumentUse]:
    """Yield what uses the argument ``name`` of ``launch``, in the file's order."""
    found = [*_in_arguments(launch, name)]
    for entry in launch.entries:
        found += _in_entry(entry, name)
    found += _in_conditions(launch, name)
    yield from sorted(found, key=lambda use: use.location.line or 0)


def _in_arguments(launch: LaunchFile, name: str) -> Iterator[ArgumentUse]:
    for argument in launch.arguments:
        value = argument.value
        if argument.origin in ("value", "default") and value and name in value.uses:
            what = f"argument {argument.name}"
            yield _use(what, argument.place, argument=(launch, argument.name))


def _in_entry(entry: Entry, name: str) -> Iterator[ArgumentUse]:
    if isinstance(entry, Include):
        yield from _in_include(entry, name)
    if isinstance(entry, Parameter):
        yield from _in_xacro(entry, name)
    for key, text in entry.texts:
        is_xacro = key == "command" and isinstance(entry, Parameter)
        if name not in text.uses or (is_xacro and any(_in_xacro(entry, name))):
            continue
        yield _use(f"{key} of {describe(entry)}", entry.place)
    if isinstance(entry, Node):
        for part in _inside(entry):
            for key, text in part.texts:
                if name in text.uses and _is_written_in(part, entry):
                    of = describe(part)
                    if not (isinstance(part, Parameter) and part.full_name):
                        of = f"{of} of {describe(entry)}"
                    what = f"{key} of {of}"
                    yield _use(what, part.place)


def _in_include(include: Include, name: str) -> Iterator[ArgumentUse]:
    """Yield the arguments of the included file that the value becomes."""
    child = include.launch
    passed = {p.name for p in include.passed if p.place.activity is not _OFF}
    for item in include.passed:
        if item.value is None or name not in item.value.uses:
            continue
        is_known = child is not None and child.argument(item.name) is not None
        yield _use(
            f"argument {item.name} of {_included(include)}",
            item.place,
            argument=(child, item.name) if child and is_known else None,
        )
    if not include.passes_all or child is None or name in passed:
        return
    argument = child.argument(name)
    if argument is not None and argument.origin == "pass_all_args":
        what = f"argument {name} of {_included(include)}"
        yield _use(what, include.place, argument=(child, name))


def _in_xacro(parameter: Entry, name: str) -> Iterator[ArgumentUse]:
    """Yield the arguments of xacro that the value becomes."""
    call = xacro_call(parameter) if isinstance(parameter, Parameter) else None
    for argument, used in () if call is None else call.uses.items():
        if call is not None and name in used:
            of = describe(parameter) if call.file is None else call.file.name
            what = f"xacro argument {argument} of {of}"
            yield _use(what, parameter.place, xacro=(call.parameter, argument))


def _in_conditions(launch: LaunchFile, name: str) -> Iterator[ArgumentUse]:
    """Yield each ``if`` and ``unless`` once, though a group's is that of many."""
    seen = set()
    for what, place, argument in _places(launch):
        for number, condition in enumerate(reversed(place.conditions)):
            where = condition.text.location
            key = (condition.kind, where)
            if name not in condition.text.uses or where.file != launch.file:
                continue
            if key not in seen:
                seen.add(key)
                is_own = number == 0 and where == place.location
                goes_on = is_own and argument and place.activity is not _OFF
                yield ArgumentUse(
                    what=f"{condition.kind} of {what if is_own else 'the group'}",
                    location=where,
                    activity=Activity.ACTIVE,
                    argument=(launch, argument) if goes_on else None,
                )


def _places(launch: LaunchFile) -> Iterator[tuple[str, Place, str]]:
    """Yield all that may have a condition; for an argument also its name."""
    for argument in launch.arguments:
        yield f"argument {argument.name}", argument.place, argument.name
    for entry in launch.entries:
        yield describe(entry), entry.place, ""
        if isinstance(entry, Include):
            for passed in entry.passed:
                yield f"argument {passed.name}", passed.place, ""
        if isinstance(entry, Node):
            for part in _inside(entry):
                yield describe(part), part.place, ""


def _is_written_in(part: Entry, node: Node) -> bool:
    """Whether ``part`` is not inherited from an outer file."""
    return part.place.location.file == node.place.location.file


def _inside(node: Node) -> tuple[Entry, ...]:
    return (*node.parameters, *node.rosparams, *node.remaps, *node.environment)


def _use(
    what: str,
    place: Place,
    *,
    argument: tuple[LaunchFile, str] | None = None,
    xacro: tuple[Parameter, str] | None = None,
) -> ArgumentUse:
    return ArgumentUse(
        what=what,
        location=place.location,
        activity=place.activity,
        argument=argument,
        xacro=xacro,
    )


def describe(entry: Entry) -> str:
    """Return what a person calls an entry."""
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
        case Remap():
            return f"remap {entry.from_name.resolved or entry.from_name.raw}"
        case Environment():
            return f"env {entry.name.resolved or entry.name.raw}"
        case RemoteMachine():
            return "machine"


def _included(include: Include) -> str:
    return include.file.raw if include.path is None else include.path.name


def argument_flow(
    launch: LaunchFile, robots: Mapping[Parameter, XacroFile]
) -> tuple[Item, ...]:
    """Return an item for each file that has arguments, with their ways in it.

    In files that are included only those arguments are listed whose value comes from
    no argument of another file: the others are seen on their path.

    Args:
        launch: The file.
        robots: What its parameters have xacro read (``xacro_robots``).
    """
    explainer = _FlowExplainer(launch, robots)
    listed = [explainer.arguments(file) for file in launch.files()]
    return tuple(item for item in listed if item.items)


@final
class _FlowExplainer:
    """Follows the arguments of one file and of those it includes."""

    def __init__(
        self, launch: LaunchFile, robots: Mapping[Parameter, XacroFile]
    ) -> None:
        self._launch = launch
        self._robots = robots
        self._left = MAX_VISITS

    def arguments(self, launch: LaunchFile) -> Item:
        """Return the arguments that are listed with one file."""
        is_root = launch is self._launch
        found = []
        for argument in launch.arguments:
            same = [a for a in launch.arguments if a.name == argument.name]
            is_only = len(same) == 1 or argument.origin != "switched off"
            value = argument.value
            comes = argument.origin in ("include", "pass_all_args")
            comes = comes and value is not None and bool(value.uses)
            if is_only and (is_root or not comes):
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
        is_outside = argument.origin in ("include", "pass_all_args")
        place = argument.place.location
        if value is not None and is_outside:
            place = value.location
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
        """Yield what uses an argument, with all that follows from it."""
        here = (id(launch), name)
        if here in path:
            return
        self._left -= len(launch.entries) + len(launch.arguments) + 1
        if self._left < 0:
            where = SourceLocation(launch.file)
            yield Item(kind="use", name="more than can be listed", location=where)
            return
        for use in uses(launch, name):
            items: tuple[Item, ...] = ()
            if use.argument is not None:
                items = tuple(self._uses(*use.argument, (*path, here)))
            elif use.xacro is not None:
                items = tuple(self._in_xacro(use))
            yield Item(
                kind="use",
                name=use.what,
                location=use.location,
                note="switched off" if use.activity is Activity.INACTIVE else "",
                items=items,
            )

    def _in_xacro(self, use: ArgumentUse) -> Iterator[Item]:
        parameter, name = use.xacro or (None, "")
        robot = None if parameter is None else self._robots.get(parameter)
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
