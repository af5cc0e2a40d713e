"""Explains a launch file as a tree of its includes, nodes and parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import final

from tool0.errors import SourceLocation
from tool0.lint.launch.model import (
    Entry,
    Include,
    LaunchFile,
    Node,
    Parameter,
    Place,
    Rosparam,
    Statement,
    Text,
)
from tool0.lint.launch.xacro_files import XacroFile, xacro_call


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """An element of a launch file, with its children."""

    kind: str
    """Kind of the item, such as ``include``, ``node``, ``param``, ``argument`` or
    ``use``."""
    name: str
    value: str | None = None
    """Value of the element; None if it has no value or if its value is unknown."""
    location: SourceLocation
    note: str = ""
    """Remark on the element, for example the reason why it has no value or is
    inactive."""
    items: tuple[Item, ...] = ()


def contents(launch: LaunchFile, robots: Mapping[Parameter, XacroFile]) -> Item:
    """Return the explanation of a file and of all files that it includes.

    Args:
        launch: The launch file.
        robots: The xacro files that the launch file's parameters load
            (``xacro_robots``).
    """
    explainer = _ContentsExplainer(robots)
    return Item(
        kind="launch",
        name=str(launch.file),
        location=SourceLocation(launch.file),
        items=tuple(explainer.entry(entry) for entry in launch.entries),
    )


@final
class _ContentsExplainer:
    """Explains the entries of one file and of the files that it includes."""

    def __init__(self, robots: Mapping[Parameter, XacroFile]) -> None:
        self._robots = robots

    def entry(self, entry: Entry) -> Item:
        """Return the item of one entry, with its children."""
        match entry:
            case Include():
                return self._include(entry)
            case Node():
                return self._node(entry)
            case Parameter():
                return self._parameter(entry, entry.full_name)
            case Rosparam():
                return _rosparam(entry)
            case Statement():
                return _statement(entry)

    def _include(self, include: Include) -> Item:
        entries = () if include.launch is None else include.launch.entries
        return _item(
            "include",
            include.file.raw if include.path is None else str(include.path),
            None,
            include.place,
            note=include.reason,
            items=tuple(map(self.entry, entries)),
        )

    def _node(self, node: Node) -> Item:
        program = f"{_shown(node.package)}/{_shown(node.type)}"
        args = [] if node.args is None else [" ".join(_shown(node.args).split())]
        parts = [self._parameter(p, p.name.resolved) for p in node.parameters]
        parts += [_rosparam(rosparam) for rosparam in node.rosparams]
        parts += [_statement(remap) for remap in node.remaps]
        return _item(
            "test" if node.is_test else "node",
            node.full_name or node.name.raw,
            " ".join([program, *args]),
            node.place,
            note=node.args.reason if node.args else "",
            items=tuple(parts),
        )

    def _parameter(self, parameter: Parameter, name: str | None) -> Item:
        robot = self._robots.get(parameter)
        value = parameter.content.resolved
        if parameter.source != "value" and value is not None:
            value = f"{parameter.source} {value}"
        return _item(
            "param",
            name or parameter.name.raw,
            value if robot is None else None,
            parameter.place,
            note=parameter.content.reason,
            items=() if robot is None else (self._robot(parameter, robot),),
        )

    def _robot(self, parameter: Parameter, robot: XacroFile) -> Item:
        """Return the item of a xacro file, with its arguments."""
        call = xacro_call(parameter)
        declared = {name for file in robot.walk() for name in file.defaults}
        given = [
            Item(
                kind="xacro arg",
                name=name,
                value=value,
                location=parameter.place.location,
                note="" if name in declared else "no file declares it",
            )
            for name, value in ({} if call is None else call.args).items()
        ]
        item = _xacro(robot)
        return replace(item, items=(*given, *item.items))


def _item(
    kind: str,
    name: str,
    value: str | None,
    place: Place,
    *,
    note: str = "",
    items: tuple[Item, ...] = (),
) -> Item:
    """Return an item.  The remark "off" comes before all other remarks."""
    return Item(
        kind=kind,
        name=name,
        value=value,
        location=place.location,
        note=_off(place) or note,
        items=items,
    )


def _statement(statement: Statement) -> Item:
    if statement.kind == "machine":
        texts = [f"{key}={_shown(text)}" for key, text in statement.texts]
        return _item("machine", "", " ".join(texts), statement.place)
    (_, name), (_, value) = statement.texts
    return _item(statement.kind, _shown(name), _shown(value), statement.place)


def _rosparam(rosparam: Rosparam) -> Item:
    file = rosparam.file
    value = "" if rosparam.command == "delete" else "YAML in the launch file"
    verb = "" if rosparam.command == "load" else f"{rosparam.command} "
    return _item(
        "rosparam",
        verb + (rosparam.namespace or "(unknown)"),
        value if file is None else _shown(file),
        rosparam.place,
        note=file.reason if file is not None else "",
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
    """Return the reason why an element is or may be inactive, or an empty text."""
    for condition in place.conditions:
        if condition.holds is False:
            return f'off: {condition.kind}="{condition.text.raw}"'
    for condition in place.conditions:
        if condition.holds is None:
            return f'perhaps off: {condition.kind}="{condition.text.raw}" is unknown'
    return ""
