"""What a launch file does, as a tree of items, for people and for programs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from tool0.errors import SourceLocation
from tool0.launch.flow import Use, uses
from tool0.launch.model import (
    Argument,
    Entry,
    Include,
    LaunchFile,
    Machine,
    Node,
    Parameter,
    Rosparam,
)
from tool0.launch.packages import Packages
from tool0.launch.text import Activity, Place, Text
from tool0.launch.xacro_files import XacroFile, xacro_call, xacro_files

MAX_LOOKS = 300_000
"""At entries, in search of what uses an argument: files may include files without
number."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """Something in a launch file, and what is in it."""

    kind: str
    """``include``, ``node``, ``param``, ``argument``, ``use`` and so on."""
    name: str
    value: str | None = None
    """None if it has none, or none that is known."""
    location: SourceLocation
    note: str = ""
    """What else is to be said: why it has no value, why it is switched off."""
    items: tuple[Item, ...] = ()


@final
class Explainer:
    """Explains one launch file with all that it includes."""

    def __init__(self, launch: LaunchFile, packages: Packages) -> None:
        self._launch = launch
        self._packages = packages
        self._xacro = {
            call.parameter: xacro_files(call, packages)
            for parameter in launch.parameters(active_only=False)
            if (call := xacro_call(parameter)) is not None
        }
        self._left = MAX_LOOKS

    def contents(self) -> Item:
        """Return what the file includes, starts and sets."""
        return self._file(self._launch, SourceLocation(self._launch.file))

    def arguments(self) -> tuple[Item, ...]:
        """Return where values come from and where they end up, a file in each item.

        In files that are included only those arguments are listed whose value comes
        from no argument of another file: the others are seen on their way.
        """
        files = [*self._launch.files()]
        listed = [self._arguments(launch) for launch in files]
        return tuple(item for item in listed if item.items)

    def _file(self, launch: LaunchFile, location: SourceLocation) -> Item:
        return Item(
            kind="launch",
            name=str(launch.file),
            location=location,
            items=tuple(self._entry(entry) for entry in launch.entries),
        )

    def _entry(self, entry: Entry) -> Item:
        match entry:
            case Include():
                return self._include(entry)
            case Node():
                return self._node(entry)
            case Parameter():
                return self._parameter(entry, entry.full_name)
            case Rosparam():
                return _rosparam(entry)
            case Machine():
                texts = [f"{key}={_shown(text)}" for key, text in entry.settings]
                return _item("machine", "", " ".join(texts), entry.place)
        kind = type(entry).__name__.lower().replace("environment", "env")
        (_, name), (_, value) = entry.texts
        return _item(kind, _shown(name), _shown(value), entry.place)

    def _include(self, include: Include) -> Item:
        inside: tuple[Item, ...] = ()
        if include.launch is not None:
            inside = tuple(self._entry(entry) for entry in include.launch.entries)
        off = _off(include.place)
        return Item(
            kind="include",
            name=include.file.raw if include.path is None else str(include.path),
            location=include.place.location,
            note=off or include.reason,
            items=inside,
        )

    def _node(self, node: Node) -> Item:
        program = f"{_shown(node.package)}/{_shown(node.type)}"
        args = [] if node.args is None else [" ".join(_shown(node.args).split())]
        parts = [self._parameter(p, p.name.resolved) for p in node.parameters]
        parts += [_rosparam(rosparam) for rosparam in node.rosparams]
        parts += [
            _item("remap", _shown(r.from_name), _shown(r.to_name), r.place)
            for r in node.remaps
        ]
        return Item(
            kind="test" if node.is_test else "node",
            name=node.full_name or node.name.raw,
            value=" ".join([program, *args]),
            location=node.place.location,
            note=_off(node.place) or (node.args.reason if node.args else ""),
            items=tuple(parts),
        )

    def _parameter(self, parameter: Parameter, name: str | None) -> Item:
        robot = self._xacro.get(parameter)
        value = parameter.content.resolved
        shown = f"{parameter.source} {value}" if value is not None else None
        if parameter.source == "value" or value is None:
            shown = value
        return Item(
            kind="param",
            name=name or parameter.name.raw,
            value=shown if robot is None else None,
            location=parameter.place.location,
            note=_off(parameter.place) or parameter.content.reason,
            items=() if robot is None else (self._robot(parameter, robot),),
        )

    def _robot(self, parameter: Parameter, robot: XacroFile) -> Item:
        """Return the xacro file that a parameter loads, with what it is given."""
        call = xacro_call(parameter)
        args = {} if call is None else call.args
        declared = {name for file in robot.walk() for name in file.defaults}
        given = [
            Item(
                kind="xacro arg",
                name=name,
                value=value,
                location=parameter.place.location,
                note="" if name in declared else "no file declares it",
            )
            for name, value in args.items()
        ]
        item = _xacro(robot)
        return Item(
            kind=item.kind,
            name=item.name,
            location=item.location,
            note=item.note,
            items=(*given, *item.items),
        )

    def _arguments(self, launch: LaunchFile) -> Item:
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
        self, launch: LaunchFile, name: str, way: tuple[tuple[int, str], ...]
    ) -> Iterator[Item]:
        """Yield what uses an argument, with all that follows from it."""
        here = (id(launch), name)
        if here in way:
            return
        self._left -= len(launch.entries) + len(launch.arguments) + 1
        if self._left < 0:
            where = SourceLocation(launch.file)
            yield Item(kind="use", name="more than can be listed", location=where)
            return
        for use in uses(launch, name):
            items: tuple[Item, ...] = ()
            if use.argument is not None:
                items = tuple(self._uses(*use.argument, (*way, here)))
            elif use.xacro is not None:
                items = tuple(self._in_xacro(use))
            yield Item(
                kind="use",
                name=use.what,
                location=use.location,
                note="switched off" if use.activity is Activity.INACTIVE else "",
                items=items,
            )

    def _in_xacro(self, use: Use) -> Iterator[Item]:
        parameter, name = use.xacro or (None, "")
        robot = None if parameter is None else self._xacro.get(parameter)
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


_ORIGINS = {
    "command line": "from the command line",
    "include": "given by the include",
    "pass_all_args": "passed on by the include",
    "value": "fixed",
    "default": "the default",
    "missing": "required, and not given",
    "switched off": "switched off",
}


def _item(kind: str, name: str, value: str, place: Place) -> Item:
    return Item(
        kind=kind, name=name, value=value, location=place.location, note=_off(place)
    )


def _rosparam(rosparam: Rosparam) -> Item:
    file = rosparam.file
    value = "YAML in the launch file"
    if file is not None:
        value = file.resolved or file.raw
    elif rosparam.command == "delete":
        value = ""
    verb = "" if rosparam.command == "load" else f"{rosparam.command} "
    return Item(
        kind="rosparam",
        name=verb + (rosparam.namespace or "(unknown)"),
        value=value,
        location=rosparam.place.location,
        note=_off(rosparam.place) or (file.reason if file is not None else ""),
    )


def _xacro(file: XacroFile) -> Item:
    return Item(
        kind="xacro",
        name=file.written if file.file is None else str(file.file),
        location=file.location,
        note=file.reason,
        items=tuple(_xacro(include) for include in file.includes),
    )


def _shown(text: Text) -> str:
    return text.raw if text.resolved is None else text.resolved


def _off(place: Place) -> str:
    """Return why something is off, or may be; empty if it is on."""
    for condition in place.conditions:
        if condition.holds is False:
            return f'off: {condition.kind}="{condition.text.raw}"'
    for condition in place.conditions:
        if condition.holds is None:
            return f'perhaps off: {condition.kind}="{condition.text.raw}" is unknown'
    return ""
