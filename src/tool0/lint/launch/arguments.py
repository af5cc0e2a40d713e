"""The arguments of a launch file: declared, given, missing and used arguments."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, final

from tool0.errors import SourceLocation, did_you_mean
from tool0.lint.launch.load_context import is_file
from tool0.lint.launch.model import (
    Argument,
    Include,
    Passed,
    Statement,
    Text,
)
from tool0.lint.launch.scope import Scope
from tool0.lint.launch.statements import read_statement


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GivenArgument:
    """Value of an argument that an include or the command line passes to the file."""

    text: Text
    origin: Literal["command line", "include", "pass_all_args"]


@final
class Arguments:
    """Records the arguments of a file while it is read."""

    def __init__(
        self,
        scope: Scope,
        given: Mapping[str, GivenArgument],
        *,
        is_included: bool,
        passes_all: bool,
    ) -> None:
        self._scope, self._given = scope, given
        self._is_included, self._passes_all = is_included, passes_all
        self._found: list[Argument] = []

    def declare(self, scope: Scope) -> None:
        """Add an ``<arg>`` to the scope."""
        name = scope.required("name").resolved
        if not name:
            return
        value, default = scope.text("value"), scope.text("default")
        if value is not None and default is not None:
            scope.report(
                "bad-argument",
                name,
                "has both value and default, and roslaunch stops here",
                "write value if it may never change, else default",
            )
        place = scope.place
        argument = Argument(name=name, place=place, origin="missing", default=default)
        if scope.holds is False:
            argument = replace(argument, origin="switched off")
        else:
            self._refuse_twice(argument, scope)
            scope.declared.setdefault(name, place.location)
            argument = self._with_value(argument, value, scope)
        self._found.append(argument)

    def _refuse_twice(self, argument: Argument, scope: Scope) -> None:
        first = scope.declared.get(argument.name)
        if first is None or self._passes_all or scope.holds is None:
            return
        earlier = [a for a in self._found if a.place.location is first]
        if all(a.place.holds is not None for a in earlier):
            scope.report(
                "duplicate-argument",
                argument.name,
                f"is declared at {first} already, and roslaunch stops here",
                "remove one of them",
            )

    def _with_value(
        self, argument: Argument, value: Text | None, scope: Scope
    ) -> Argument:
        """Return the argument with the value that it has after its declaration."""
        name = argument.name
        given = self._given.get(name)
        if value is not None:
            if given is not None and not self._passes_all:
                self._refuse_override(argument, given, scope)
            scope.values[name] = _if_active(value, scope)
            return replace(argument, value=scope.values[name], origin="value")
        if given is not None:
            return replace(argument, value=given.text, origin=given.origin)
        if name in scope.values:  # declared twice, which has already been reported
            return replace(argument, value=scope.values[name], origin="default")
        if argument.default is not None:
            scope.values[name] = _if_active(argument.default, scope)
            return replace(argument, value=scope.values[name], origin="default")
        return argument

    def _refuse_override(
        self, argument: Argument, given: GivenArgument, scope: Scope
    ) -> None:
        place = given.text.location
        where = "on the command line" if place.file is None else f"at {place}"
        scope.report(
            "constant-argument",
            argument.name,
            f"has a fixed value (at {argument.place.location}), and another is given "
            f"{where}: roslaunch stops here",
            "write default instead of value, or do not give it",
            location=None if place.file is None else place,
        )

    def report_missing(self, include: Scope) -> None:
        """Report the required arguments that the include does not pass."""
        for argument in self._found:
            name = argument.name
            if argument.origin == "missing" and name not in self._scope.values:
                include.report(
                    "missing-argument",
                    name,
                    f"is an argument that {self._scope.file.name} requires (declared "
                    f"at {argument.place.location}), and it is not given here",
                    f'write <arg name="{name}" value="…"/> into this <include>',
                    severity="error" if name in self._scope.used else "warning",
                )

    def finished(self) -> tuple[Argument, ...]:
        """Return all arguments at the end of the file, and report unused arguments."""
        first = {argument.name: argument for argument in reversed(self._found)}
        for name in dict.fromkeys(argument.name for argument in self._found):
            if name not in self._scope.used:
                self._scope.report(
                    "unused-argument",
                    name,
                    "is declared, and nothing in the file uses it: its value has no "
                    "effect",
                    f"use it as $(arg {name}), or remove it",
                    severity="warning",
                    location=first[name].place.location,
                )
        return tuple(self._found)

    def report_unknown(self) -> None:
        """Report command-line arguments that the file does not declare."""
        declared = {argument.name for argument in self._found}
        for name in self._given:
            if name not in declared:
                self._scope.report(
                    "unused-argument",
                    name,
                    "is given on the command line, and the file declares no such "
                    "argument" + did_you_mean(name, declared),
                    severity="warning",
                    location=SourceLocation(self._scope.file),
                )


def _if_active(text: Text, scope: Scope) -> Text:
    """Return ``text``, without its value if the element may be inactive."""
    if scope.holds is not None:
        return text
    reason = "it depends on an if or unless that is unknown"
    return replace(text, resolved=None, reason=text.reason or reason)


def read_include(
    scope: Scope,
) -> tuple[Include, dict[str, GivenArgument], list[Statement]]:
    """Return an ``<include>`` with the arguments and environment that it passes."""
    file = scope.required("file")
    namespace = scope.inner_namespace()
    passes_all = scope.boolean("pass_all_args")
    given = _all_given(scope) if passes_all else {}
    environment: list[Statement] = []
    passed = tuple(_passed(scope, given, environment, passes_all=passes_all))
    namespace_text = scope.text("ns")
    path, reason = None, file.reason or "no file is named"
    if file.resolved:
        path = Path(os.path.normpath(file.resolved))
        scope.require_file(file, "include")
        reason = "" if is_file(path) else f"{path} does not exist"
    include = Include(
        place=replace(scope.place, namespace=namespace),
        file=file,
        path=path,
        passed=passed,
        passes_all=passes_all,
        settings=() if namespace_text is None else (("ns", namespace_text),),
        reason=reason,
    )
    return include, given, environment


def _all_given(scope: Scope) -> dict[str, GivenArgument]:
    """Return the file's arguments in the form in which pass_all_args passes them."""
    scope.used.update(scope.declared, scope.values)
    given = {}
    for name in {**scope.declared, **scope.values}:
        text = scope.values.get(name)
        given[name] = GivenArgument(
            text=Text(
                raw=f"$(arg {name})",
                resolved=None if text is None else text.resolved,
                location=scope.location,
                uses=(name,),
                reason=f"argument '{name}' has no value"
                if text is None
                else text.reason,
            ),
            origin="pass_all_args",
        )
    return given


def _passed(
    scope: Scope,
    given: dict[str, GivenArgument],
    environment: list[Statement],
    *,
    passes_all: bool,
) -> Iterator[Passed]:
    """Yield each ``<arg>`` in an include, and add it to the passed arguments."""
    names: set[str] = set()
    for at in scope.children():
        if at.tag == "env":
            environment.append(read_statement(at))
            continue
        name = at.required("name").resolved
        if not name:
            continue
        value = at.text("value")
        text = at.text("default") if value is None else value
        yield Passed(name=name, place=at.place, value=text)
        if at.holds is False:
            continue
        if name in names and at.holds and not passes_all:
            at.report(
                "duplicate-argument",
                name,
                "is given twice in one <include>: roslaunch stops here",
                "remove one of them",
            )
        names.add(name)
        if text is not None and (value is not None or name not in given):
            given[name] = GivenArgument(text=text, origin="include")
        elif text is None and name not in given:
            at.report(
                "missing-argument",
                name,
                "is passed to an include without a value: roslaunch stops here",
                f'write value="…", such as value="$(arg {name})"',
            )
