"""Reads the includes of Python launch files: the included file and its arguments."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Final

from tool0.description.packages import source_path
from tool0.errors import did_you_mean, is_typo, nearest_name
from tool0.lint.launch.load_context import is_file
from tool0.lint.launch.model import Argument, Include, LaunchFile, Passed
from tool0.lint.launch.python.substitution import Resolver
from tool0.lint.launch.python.values import Made

_SOURCES: Final = ("PythonLaunchDescriptionSource", "AnyLaunchDescriptionSource")
_OTHER_SOURCES: Final = (
    "FrontendLaunchDescriptionSource",
    "XMLLaunchDescriptionSource",
    "YAMLLaunchDescriptionSource",
)


def read_include(made: Made, resolver: Resolver) -> Include:
    """Return an ``IncludeLaunchDescription`` action as an include.

    If the file is not read, the field ``reason`` of the include contains the reason.
    """
    source = made.get("launch_description_source")
    where, is_other = made.location, False
    if isinstance(source, Made) and source.name in (*_SOURCES, *_OTHER_SOURCES):
        is_other = source.name in _OTHER_SOURCES
        where, source = source.location, source.get("launch_file_path")
    file = resolver.text(source, where)
    include = Include(
        place=resolver.state.place(made.location),
        file=file,
        path=None,
        passed=_passed(made, resolver),
        reason=file.reason,
    )
    if not file.resolved:
        return replace(include, reason=file.reason or "no file is named")
    path = source_path(Path(os.path.normpath(file.resolved)))
    include = replace(include, path=path)
    if not is_file(path):
        resolver.report(
            file.location,
            "missing-file",
            file.resolved,
            "does not exist, and IncludeLaunchDescription needs it",
            "correct the path; it begins in the share folder of a package",
        )
        return replace(include, reason=f"{path} does not exist")
    if is_other or path.suffix != ".py":
        reason = "launch files of ROS 2 in XML or YAML are not read"
        return replace(include, reason=reason)
    return include


def _passed(made: Made, resolver: Resolver) -> tuple[Passed, ...]:
    """Return the arguments that an include passes."""
    value, where = made.get("launch_arguments"), made.place("launch_arguments")
    if isinstance(value, dict):
        resolver.report(
            where,
            "bad-value",
            "launch_arguments",
            "is a dict, and launch expects pairs: it stops here",
            "write {…}.items()",
        )
        value = list(value.items())
    passed = []
    for pair in value if isinstance(value, list | tuple) else ():
        if isinstance(pair, list | tuple) and len(pair) == 2:
            name = resolver.text(pair[0], where).resolved
            text = resolver.text(pair[1], where)
            if name is not None:
                place = resolver.state.place(where)
                passed.append(Passed(name=name, place=place, value=text))
    return tuple(passed)


def set_passed(include: Include, resolver: Resolver) -> None:
    """Set the configurations that an include passes; they remain set afterwards."""
    state = resolver.state
    for item in include.passed:
        if item.value is not None:
            state.configurations[item.name] = state.if_active(item.value)


def check_include(
    include: Include,
    launch: LaunchFile,
    missing: Iterable[Argument],
    resolver: Resolver,
) -> None:
    """Report undeclared arguments that an include passes, and missing arguments.

    Args:
        include: The include.
        launch: The included launch file.
        missing: The arguments that the file requires and that the include does not
            pass.
        resolver: The resolver of the including file.
    """
    declared = {argument.name for argument in launch.arguments}
    for passed in include.passed:
        name = passed.name
        if name in declared or launch.notes or name in resolver.state.uses:
            continue
        resolver.report(
            passed.place.location,
            "unused-argument",
            name,
            f"is no argument of {launch.file.name}, and has no effect there"
            + did_you_mean(name, declared),
            f"remove it, or declare it in {launch.file}",
            severity="error"
            if is_typo(name, nearest_name(name, declared))
            else "warning",
        )
    for argument in missing:
        resolver.report(
            include.file.location,
            "missing-argument",
            argument.name,
            f"is an argument that {launch.file.name} requires (declared at "
            f"{argument.place.location}), and it is not given here: launch stops",
            f'add "{argument.name}" to launch_arguments',
        )
