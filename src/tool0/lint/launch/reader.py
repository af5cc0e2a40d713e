"""Reads launch files as roslaunch does, with arguments, groups and includes.

Python launch files are read as in ROS 2 (package ``python``).

Every problem is reported as a finding, and reading continues.  Values that are affected
by a problem remain unresolved.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import final

from tool0.description.finding import Finding
from tool0.errors import SourceLocation, did_you_mean
from tool0.lint.launch import grammar
from tool0.lint.launch.arguments import Arguments, GivenArgument, read_include
from tool0.lint.launch.load_context import (
    MAX_ELEMENTS,
    MAX_FILES,
    MAX_NESTING,
    LoadContext,
)
from tool0.lint.launch.model import Entry, Include, LaunchFile, Node, Text
from tool0.lint.launch.python.reader import read_python_launch
from tool0.lint.launch.scope import Scope
from tool0.lint.launch.statements import (
    read_node,
    read_param,
    read_rosparam,
    read_statement,
)
from tool0.lint.packages import PackageIndex
from tool0.lint.robot.elements import Tag


def read_launch(
    file: Path,
    arguments: Mapping[str, str] | None = None,
    packages: PackageIndex | None = None,
) -> LaunchFile:
    """Return the content of a launch file, including all files that it includes.

    Args:
        file: The launch file.
        arguments: The file's arguments, which the user gives as ``name:=value``.
        packages: The packages in which ``$(find …)`` searches.
    """
    texts = {
        name: Text(raw=value, resolved=value, location=SourceLocation(None))
        for name, value in (arguments or {}).items()
    }
    context = LoadContext(packages or PackageIndex())
    file = file.absolute()
    if file.suffix == ".py":
        return read_python_launch(file, texts, context)
    given = {
        name: GivenArgument(text=text, origin="command line")
        for name, text in texts.items()
    }
    root = context.root(file)
    if isinstance(root, Finding):
        return LaunchFile(file=file, findings=(root,))
    reader = _FileReader(
        Scope(context=context, file=file, element=root, namespace="/"), given
    )
    launch = reader.read()
    reader.arguments.report_unknown()
    return replace(launch, findings=tuple(dict.fromkeys(reader.scope.findings)))


@final
class _FileReader:
    """Reads one file.  An instance is used only once."""

    def __init__(
        self,
        scope: Scope,
        given: Mapping[str, GivenArgument],
        include: Include | None = None,
    ) -> None:
        self.scope = replace(
            scope,
            values={name: value.text for name, value in given.items()},
            declared={},
            used=set(),
            findings=[],
            remaps=list(scope.remaps),
            environment=list(scope.environment),
            anonymous={},
        )
        self.arguments = Arguments(
            self.scope,
            given,
            is_included=include is not None,
            passes_all=include is not None and include.passes_all,
        )
        self._context = scope.context
        self._entries: list[Entry] = []

    def read(self) -> LaunchFile:
        """Return the content of the file."""
        scope, root = self.scope, self.scope.element
        scope.findings += grammar.findings(Tag(root))
        if root.getAttribute("deprecated"):
            scope.report(
                "deprecated",
                scope.file.name,
                f"says that it is deprecated: {root.getAttribute('deprecated')}",
                severity="warning",
            )
        self._read_children(scope.at(root))
        return LaunchFile(
            file=scope.file,
            arguments=self.arguments.finished(),
            entries=tuple(self._entries),
            findings=tuple(dict.fromkeys(scope.findings)),
        )

    def _read_children(self, scope: Scope) -> None:
        for inner in scope.children():
            if not self._context.spend("elements"):
                here = replace(scope, element=inner.element)
                _stop(here, f"more than {MAX_ELEMENTS} elements")
                return
            self._read_element(inner)

    def _read_element(self, scope: Scope) -> None:
        entry: Entry | None = None
        match scope.tag:
            case "arg":
                self.arguments.declare(scope)
            case "group":
                self._read_group(scope)
            case "include":
                entry = self._include(scope)
            case "param":
                entry = read_param(scope)
            case "rosparam":
                entry = read_rosparam(scope)
            case "node" | "test":
                entry = read_node(scope)
                self._claim_name(entry, scope)
            case "remap" | "env" | "machine":
                entry = read_statement(scope)
                if entry.kind == "env" and scope.holds is not False:
                    scope.environment.append(entry)
            case "master":
                scope.report(
                    "deprecated",
                    "master",
                    "is an element that roslaunch ignores",
                    "remove it",
                    severity="warning",
                )
        if entry is not None:
            self._entries.append(entry)

    def _read_group(self, scope: Scope) -> None:
        if self._context.depth >= MAX_NESTING:
            _stop(scope, f"more than {MAX_NESTING} inside one another")
            return
        self._context.depth += 1
        inside = scope.group(scope.inner_namespace())
        self._read_children(inside)
        self._context.depth -= 1

    def _claim_name(self, node: Node, scope: Scope) -> None:
        """Report a second node with the same name, because roslaunch refuses it."""
        name = node.full_name
        if name is None or not scope.holds:
            return
        first = self._context.nodes.setdefault(name, node.place.location)
        if first is not node.place.location:
            scope.report(
                "duplicate-node",
                name,
                f"is the name of the node at {first}, too: roslaunch stops here",
                "give one of them another name, or a namespace by ns",
            )

    def _include(self, scope: Scope) -> Include:
        """Return an ``<include>``, with the content of the included file."""
        include, given, environment = read_include(scope)
        if include.reason or include.path is None or scope.holds is False:
            return replace(include, reason=include.reason or "switched off")
        if self._context.depth >= MAX_NESTING:
            _stop(scope, f"more than {MAX_NESTING} inside one another")
            return replace(include, reason="too many files inside one another")
        if not self._context.spend("files"):
            _stop(scope, f"more than {MAX_FILES} files")
            return replace(include, reason="too many files")
        path = include.path.absolute()
        values = frozenset((name, g.text.resolved) for name, g in given.items())
        if not self._context.enter((path, include.place.namespace, values)):
            scope.report(
                "recursive-include",
                str(path),
                "includes itself with the same arguments: roslaunch would not end",
                "remove the include, or end it by an if",
            )
            return replace(include, reason="it includes itself")
        root = self._context.root(path)
        if isinstance(root, Finding):
            scope.findings.append(root)
            include = replace(include, reason="it is no launch file that can be read")
        else:
            outer = replace(
                scope,
                file=path,
                element=root,
                namespace=include.place.namespace,
                # as in roslaunch, an empty list is not shared
                private=scope.private or [],
                environment=[*scope.environment, *environment],
            )
            reader = _FileReader(outer, given, include)
            self._context.depth += 1
            launch = reader.read()
            self._context.depth -= 1
            include = replace(include, launch=launch)
            scope.findings += launch.findings
            _check_passed(include, launch, scope)
            reader.arguments.report_missing(scope)
        self._context.leave()
        return include


def _stop(scope: Scope, why: str) -> None:
    message = f"is not read any more: {why} in these files"
    scope.report("too-large", scope.tag, message)


def _check_passed(include: Include, launch: LaunchFile, scope: Scope) -> None:
    """Report arguments that the included file does not declare."""
    declared = {argument.name for argument in launch.arguments}
    for passed in () if include.passes_all else include.passed:
        if passed.name in declared or passed.place.holds is False:
            continue
        if passed.value is not None:
            scope.report(
                "unused-argument",
                passed.name,
                f"is no argument of {launch.file.name}, and roslaunch stops here"
                + did_you_mean(passed.name, declared),
                f"remove it, or declare it in {grammar.canonical(str(launch.file))}",
                location=passed.place.location,
            )
