"""Where the values of arguments come from and where they end up, explained."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import final

from tool0.errors import SourceLocation
from tool0.lint.launch.flow import Use, uses
from tool0.lint.launch.item import Item
from tool0.lint.launch.model import Argument, LaunchFile, Parameter
from tool0.lint.launch.text import Activity
from tool0.lint.launch.xacro_files import XacroFile

MAX_LOOKS = 300_000
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


def argument_ways(
    launch: LaunchFile, robots: Mapping[Parameter, XacroFile]
) -> tuple[Item, ...]:
    """Return an item for each file that has arguments, with their ways in it.

    In files that are included only those arguments are listed whose value comes from
    no argument of another file: the others are seen on their way.

    Args:
        launch: The file.
        robots: What its parameters have xacro read (``xacro_robots``).
    """
    explainer = _Explainer(launch, robots)
    listed = [explainer.arguments(file) for file in launch.files()]
    return tuple(item for item in listed if item.items)


@final
class _Explainer:
    """Follows the arguments of one file and of those it includes."""

    def __init__(
        self, launch: LaunchFile, robots: Mapping[Parameter, XacroFile]
    ) -> None:
        self._launch = launch
        self._robots = robots
        self._left = MAX_LOOKS

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
