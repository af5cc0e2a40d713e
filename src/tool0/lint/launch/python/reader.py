"""Reads the actions of Python launch files of ROS 2, in launch order.

First, the file is interpreted (``interpreter``), which gives the tree of its actions.
After that, the actions are processed in the same way as by launch, but no program is
started.  Any part that cannot be determined without running Python is reported as a
note.
"""

from __future__ import annotations

import ast
import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import final

from tool0.description.finding import Finding, Severity, error_at
from tool0.errors import (
    DescriptionError,
    SourceLocation,
)
from tool0.lint.launch.load_context import (
    MAX_ELEMENTS,
    MAX_FILES,
    MAX_NESTING,
    LoadContext,
    read_limited,
)
from tool0.lint.launch.model import (
    Condition,
    Entry,
    Include,
    LaunchFile,
    Origin,
    Text,
)
from tool0.lint.launch.python.arguments import DeclaredArguments
from tool0.lint.launch.python.includes import check_include, read_include, set_passed
from tool0.lint.launch.python.interpreter import Interpreter, TooLongError
from tool0.lint.launch.python.nodes import NodeReader
from tool0.lint.launch.python.settings import (
    push_namespace,
    read_condition,
    read_process,
    set_configuration,
    set_parameter,
    set_statement,
)
from tool0.lint.launch.python.state import LaunchState
from tool0.lint.launch.python.substitution import Resolver
from tool0.lint.launch.python.values import (
    Choice,
    Function,
    Made,
    Unknown,
    Value,
)

_ENTRY = "generate_launch_description"
_NODES = ("Node", "LifecycleNode", "ComposableNodeContainer")
_NESTED = {
    "TimerAction": ("actions",),
    "ROSTimer": ("actions",),
    "RosTimer": ("actions",),
    "OnProcessExit": ("on_exit",),
    "OnProcessStart": ("on_start",),
    "OnExecutionComplete": ("on_completion",),
    "OnStateTransition": ("entities",),
    "OnProcessIO": ("on_stdin", "on_stdout", "on_stderr"),
    "OnShutdown": (),
}
"""Arguments that contain actions to execute later, listed by the class of the action or
event handler."""


def read_python_launch(
    file: Path, arguments: Mapping[str, Text], context: LoadContext
) -> LaunchFile:
    """Return the content of a launch file, including all files that it includes.

    Args:
        file: The launch file.
        arguments: The arguments given on the command line.
        context: The packages and the limits.
    """
    state = LaunchState(context=context, configurations=dict(arguments))
    reader = PythonLaunchReader(file, state, dict.fromkeys(arguments, "command line"))
    launch = reader.read()
    notes = list(launch.notes)
    if not notes:
        reader.arguments.report_unknown(arguments, reader.resolver)
    missing = ", ".join(argument.name for argument in reader.arguments.missing)
    if missing:
        notes.append(
            f"{file}: what depends on {missing} was not checked: no default, and no "
            "value is given"
        )
    return replace(
        launch, findings=tuple(dict.fromkeys(reader.findings)), notes=tuple(notes)
    )


@final
class PythonLaunchReader:
    """Reads one file.  An instance is used only once."""

    def __init__(
        self, file: Path, state: LaunchState, given: Mapping[str, Origin]
    ) -> None:
        self.file = file
        self.state = state
        self.findings: list[Finding] = []
        self.notes: list[str] = []
        self.arguments = DeclaredArguments(file, given)
        self._entries: list[Entry] = []
        self._later: list[tuple[Value, LaunchState]] = []
        self._context = state.context
        self._interpreter: Interpreter | None = None
        self._words: list[str] = []

    def read(self) -> LaunchFile:
        """Return the content of the file."""
        try:
            actions = self._interpreted()
            if actions is not None:
                self._execute(actions)
                while self._later:
                    value, state = self._later.pop(0)
                    self._within(state, value)
        except (TooLongError, RecursionError):
            where = SourceLocation(self.file)
            self._report(
                where, "too-large", self.file.name, "has too many steps to be followed"
            )
        if self._interpreter is not None:
            self.findings += self._interpreter.findings
        self.arguments.report_unused(self.resolver, self._words)
        return LaunchFile(
            file=self.file,
            arguments=tuple(self.arguments.found),
            entries=tuple(self._entries),
            findings=tuple(dict.fromkeys(self.findings)),
            notes=tuple(dict.fromkeys(self.notes)),
        )

    def _interpreted(self) -> Value:
        """Return the result of ``generate_launch_description``; None if missing."""
        start = SourceLocation(self.file)
        try:
            raw = read_limited(self.file)
            with warnings.catch_warnings():
                # Python warns of invalid escape sequences
                warnings.simplefilter("ignore")
                tree = ast.parse(raw, filename=str(self.file))
        except DescriptionError as error:
            self._report(start, "not-python", self.file.name, error.message)
            return None
        except (SyntaxError, ValueError, MemoryError) as error:
            line = getattr(error, "lineno", None)
            why = getattr(error, "msg", None) or str(error)
            where = SourceLocation(self.file, line)
            self._report(where, "not-python", "", f"is no Python: {why}")
            return None
        self._words = [
            node.value
            for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        ]
        self._interpreter = Interpreter(
            self.file, tree, self._package_folder, self._perform
        )
        entry = self._interpreter.module.names.get(_ENTRY)
        if not isinstance(entry, Function):
            self._report(
                start,
                "not-launch",
                self.file.name,
                f"is no launch file: it defines no function {_ENTRY}",
                f"write def {_ENTRY}(), which returns a LaunchDescription",
            )
            return None
        return self._interpreter.run(entry, (), {})

    # --- values ---

    @property
    def resolver(self) -> Resolver:
        """Resolver for the current state."""
        return Resolver(self.file, self.state, self._report)

    def _perform(self, value: Value) -> Value:
        text = self.resolver.text(value, SourceLocation(self.file))
        return Unknown(text.reason) if text.resolved is None else text.resolved

    def _package_folder(self, name: Value, where: SourceLocation) -> Value:
        if not isinstance(name, str):
            return Unknown("a package whose name is unknown")
        text = self.resolver.package_folder(name, where)
        return Unknown(text.reason) if text.resolved is None else text.resolved

    def _report(
        self,
        location: SourceLocation,
        rule: str,
        key: str,
        message: str,
        remedy: str = "",
        *,
        severity: Severity = "error",
    ) -> None:
        """Add a finding unless the current action is inactive."""
        if self.state.holds is not False:
            self.findings.append(
                error_at(location, rule, key, message, remedy, severity=severity)
            )

    # --- actions ---

    def _within(self, state: LaunchState, actions: Value) -> None:
        """Process actions in the given state."""
        before, self.state = self.state, state
        try:
            self._execute(actions)
        finally:
            self.state = before

    def _execute(self, value: Value) -> None:
        """Process an action or a list of actions."""
        match value:
            case list() | tuple():
                for item in value:
                    self._execute(item)
            case Choice(values=values):
                where = SourceLocation(self.file)
                text = Text(raw="?", resolved=None, location=where, reason="unknown")
                unknown = Condition(kind="if", text=text, holds=None)
                for item in values:
                    self._within(self.state.under(unknown), item)
            case Made():
                self._execute_made(value)
            case Unknown(reason=reason):
                self._note(reason)

    def _note(self, reason: str) -> None:
        self.state.unread.append(reason)
        self.notes.append(f"{self.file}: not analysed in full: {reason}")

    def _execute_made(self, made: Made) -> None:
        if not self._context.spend("elements"):
            why = f"is not read any more: more than {MAX_ELEMENTS} actions"
            self._report(made.location, "too-large", made.name, why)
            return
        condition = read_condition(made.get("condition"), made.location, self.resolver)
        if condition is None:
            self._dispatch(made)
            return
        before = self.state
        self.state = before.under(condition)
        self._dispatch(made)
        self.state, changed = before, self.state
        if condition.holds is not False:  # settings made by the action remain set
            self.state = replace(changed, conditions=before.conditions)

    def _dispatch(self, made: Made) -> None:
        name = made.name
        if name in _NODES:
            self._entries.append(NodeReader(made, self.resolver).read())
        elif name in _NESTED:
            self._nested(made)
        elif name == "LaunchDescription":
            self._execute(made.get("initial_entities"))
        elif name == "DeclareLaunchArgument":
            self.arguments.declare(made, self.resolver)
        elif name == "IncludeLaunchDescription":
            self._include(made)
        elif name == "GroupAction":
            self._group(made)
        elif name == "OpaqueFunction":
            self._opaque(made)
        elif name == "RegisterEventHandler":
            self._execute(made.get("event_handler"))
        elif name in ("SetLaunchConfiguration", "UnsetLaunchConfiguration"):
            set_configuration(made, self.resolver)
        elif name in ("PushRosNamespace", "PushROSNamespace"):
            push_namespace(made, self.resolver)
        elif name in ("SetRemap", "SetEnvironmentVariable"):
            self._entries.append(set_statement(made, self.resolver))
        elif name in ("SetParameter", "SetUseSimTime"):
            set_parameter(made, self.resolver)
        elif name == "ExecuteProcess":
            self._entries.append(read_process(made, self.resolver))
            self._execute_later(made.get("on_exit"))
        elif name == "LogInfo":
            self.resolver.text(made.get("msg"), made.location)

    def _nested(self, made: Made) -> None:
        """Store actions that an event or a timer starts, so that they run last."""
        for key in _NESTED[made.name]:
            self._execute_later(made.get(key))

    def _execute_later(self, actions: Value) -> None:
        if isinstance(actions, Function) and self._interpreter is not None:
            event = Unknown("an event")
            actions = self._interpreter.run(actions, (event, event), {})
        if actions is not None:
            self._later.append((actions, self.state))

    def _group(self, made: Made) -> None:
        scoped = made.get("scoped") is not False
        state = self.state.scoped() if scoped else self.state
        given = made.get("launch_configurations")
        for key, item in given.items() if isinstance(given, dict) else ():
            state.configurations[str(key)] = self.resolver.text(item, made.location)
        if self._context.depth >= MAX_NESTING:
            why = f"is not read any more: more than {MAX_NESTING} inside one another"
            self._report(made.location, "too-large", made.name, why)
            return
        self._context.depth += 1
        if scoped:
            self._within(state, made.get("actions"))
        else:
            self._execute(made.get("actions"))
        self._context.depth -= 1

    def _opaque(self, made: Made) -> None:
        """Process the actions of an ``OpaqueFunction``, if they can be interpreted."""
        function = made.get("function")
        if not isinstance(function, Function) or self._interpreter is None:
            self._note(f"the function at line {made.location.line} is not in the file")
            return
        given, extra = made.get("args"), made.get("kwargs")
        arguments = [Made("LaunchContext", made.location), *_list(given)]
        keywords = extra if isinstance(extra, dict) else {}
        result = self._interpreter.run(function, tuple(arguments), keywords)
        self._execute(result)

    # --- includes ---

    def _include(self, made: Made) -> None:
        """Process an ``IncludeLaunchDescription`` action."""
        include = read_include(made, self.resolver)
        if self.state.holds is False:
            include = replace(include, reason=include.reason or "switched off")
        elif include.reason or include.path is None:
            self.state.unread.append(include.reason)
            set_passed(include, self.resolver)
        else:
            include = self._read_included(include, include.path)
        self._entries.append(include)

    def _read_included(self, include: Include, path: Path) -> Include:
        context, where = self._context, include.file.location
        if context.depth >= MAX_NESTING or not context.spend("files"):
            limits = f"{MAX_FILES} files, or {MAX_NESTING} inside one another"
            why = f"is not read any more: more than {limits}"
            self._report(where, "too-large", path.name, why)
            return replace(include, reason="too many files")
        set_passed(include, self.resolver)
        values = frozenset(
            (name, text.resolved) for name, text in self.state.configurations.items()
        )
        if not context.enter((path, self.state.namespace, values)):
            self._report(
                where,
                "recursive-include",
                str(path),
                "includes itself with the same arguments: launch would not end",
                "remove the include, or end it by a condition",
            )
            return replace(include, reason="it includes itself")
        origins: dict[str, Origin] = {item.name: "include" for item in include.passed}
        reader = PythonLaunchReader(path, self.state, origins)
        context.depth += 1
        launch = reader.read()
        context.depth -= 1
        context.leave()
        self.findings += launch.findings
        self.notes += launch.notes
        missing = reader.arguments.missing
        check_include(include, launch, missing, self.resolver)
        return replace(include, launch=launch)


def _list(value: Value) -> list[Value]:
    return list(value) if isinstance(value, list | tuple) else []
