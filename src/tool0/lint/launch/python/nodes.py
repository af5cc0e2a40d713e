"""Reads the nodes of a Python launch file: programs, arguments and parameters."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, final

from tool0.description.finding import Severity
from tool0.errors import SourceLocation, is_typo
from tool0.lint.launch import grammar as roslaunch
from tool0.lint.launch.model import (
    Node,
    Parameter,
    Place,
    Rosparam,
    Statement,
    Text,
)
from tool0.lint.launch.python.executables import check_executable
from tool0.lint.launch.python.parameters import ParameterReader
from tool0.lint.launch.python.substitution import Resolver, unresolved
from tool0.lint.launch.python.values import Choice, Made, Unknown, Value, is_text

_OUTPUTS: Final = ("screen", "log", "both", "own_log", "full")
_TEXTS: Final = ("output", "prefix", "exec_name")


@final
class NodeReader:
    """Reads a ``Node``, ``LifecycleNode`` or ``ComposableNodeContainer``."""

    def __init__(self, made: Made, resolver: Resolver) -> None:
        self._made, self._state, self._resolver = made, resolver.state, resolver
        self._where = made.location
        self._namespace: str | None = None
        self._full_name: str | None = None

    def read(self) -> Node:
        """Return the node, and report its faults."""
        package = self._text("package")
        program, args = self._text("executable"), self._words("arguments")
        name = self._text("name")
        self._set_names(name)
        self._check_program(package, program, name)
        parameters, rosparams = self._parameters()
        texts = [(k, self._text(k)) for k in _TEXTS if is_text(self._made.get(k))]
        return Node(
            place=self._place(self._where, self._namespace),
            is_test=False,
            package=package,
            type=program,
            name=replace(name, raw=name.raw or program.raw),
            full_name=self._full_name,
            args=_joined(args, self._made.place("arguments")) if args else None,
            words=tuple(text.resolved or "" for text in args),
            settings=tuple(texts),
            parameters=tuple(parameters),
            rosparams=tuple(rosparams),
            remaps=(*self._state.remaps, *self._remaps()),
            environment=self._state.environment,
        )

    def _report(
        self,
        key: str,
        rule: str,
        message: str,
        remedy: str = "",
        *,
        subject: str = "",
        severity: Severity = "error",
    ) -> None:
        where, subject = self._made.place(key), subject or key
        self._resolver.report(where, rule, subject, message, remedy, severity=severity)

    def _place(self, where: SourceLocation, namespace: str | None) -> Place:
        conditions = self._state.conditions
        return Place(location=where, namespace=namespace, conditions=conditions)

    def _text(self, key: str) -> Text:
        value, where = self._made.get(key), self._made.place(key)
        if value is None:
            return unresolved("", f"'{key}' is not given", where)
        return self._resolver.text(value, where)

    def _set_names(self, name: Text) -> None:
        namespace = self._state.namespace
        if self._made.get("namespace") is not None:
            own = self._text("namespace").resolved
            is_known = own is not None and namespace is not None
            namespace = (
                roslaunch.as_namespace(roslaunch.join(namespace or "", own or ""))
                if is_known
                else None
            )
        self._namespace = namespace
        if namespace is None or not name.resolved:
            return
        self._full_name = roslaunch.canonical(namespace + name.resolved)
        if not self._state.holds:
            return
        nodes = self._state.context.nodes
        first = nodes.setdefault(self._full_name, self._where)
        if first is not self._where:
            self._report(
                "name",
                "duplicate-node",
                f"is the name of the node at {first}, too: their services and "
                "parameters are mixed up",
                "give one of them another name or namespace",
                subject=self._full_name,
                severity="warning",
            )

    def _check_program(self, package: Text, program: Text, name: Text) -> None:
        if name.resolved is not None and "/" in name.resolved:
            self._report(
                "name",
                "bad-name",
                "is a node's name with a namespace in it: launch stops here",
                "write the namespace into namespace=",
                subject=name.resolved,
            )
        output = self._made.get("output")
        if isinstance(output, str) and output not in _OUTPUTS:
            valid = ", ".join(_OUTPUTS)
            self._report("output", "bad-value", f"must be {valid}, not '{output}'")
        if not package.resolved:
            return
        packages = self._state.context.packages
        folder = packages.get(package.resolved)
        if folder is not None and program.resolved:
            where = self._made.place("executable")
            check_executable(
                package.resolved, folder, program.resolved, where, self._resolver
            )
        near = None if folder is not None else packages.nearest(package.resolved)
        if is_typo(package.resolved, near):
            self._report(
                "package",
                "missing-package",
                f"is a package that is not found here; did you mean '{near}'?",
                f"write {near}, or put the package into the workspace",
                subject=package.resolved,
            )

    def _words(self, key: str) -> list[Text]:
        """Return the items of an argument that is a list of texts."""
        value, where = self._made.get(key), self._made.place(key)
        if isinstance(value, list | tuple):
            return [self._resolver.text(item, where) for item in value]
        if value is not None and not isinstance(value, Unknown | Choice):
            self._must_be_list(key, value, '["…", "…"]')
            return []
        return [] if value is None else [unresolved("…", "unknown", where)]

    def _must_be_list(self, key: str, value: Value, example: str) -> None:
        kind = value.name if isinstance(value, Made) else type(value).__name__
        self._report(
            key,
            "bad-value",
            f"must be a list, and is a {kind}: launch stops here",
            f"write {key}={example}",
        )

    def _remaps(self) -> list[Statement]:
        value, where = self._made.get("remappings"), self._made.place("remappings")
        if value is None or isinstance(value, Unknown | Choice | Made):
            return []
        if not isinstance(value, list | tuple):
            self._must_be_list("remappings", value, '[("from", "to")]')
            return []
        remaps = []
        for pair in value:
            if isinstance(pair, Unknown | Choice | Made):
                continue
            if not (isinstance(pair, list | tuple) and len(pair) == 2):
                self._report(
                    "remappings",
                    "bad-value",
                    "must contain pairs of names: launch stops here",
                    'write remappings=[("from", "to")]',
                )
                continue
            first, second = (self._resolver.text(item, where) for item in pair)
            place = self._place(where, self._namespace)
            texts = (("from", first), ("to", second))
            remaps.append(Statement(kind="remap", place=place, texts=texts))
        return remaps

    def _parameters(self) -> tuple[list[Parameter], list[Rosparam]]:
        given, where = self._made.get("parameters"), self._made.place("parameters")
        if isinstance(given, dict) or is_text(given):
            self._must_be_list("parameters", given, "[…]")
        # parameters that SetParameter has set
        items: list[Value] = [dict(self._state.parameters)]
        items += given if isinstance(given, list | tuple) else ()
        reader = ParameterReader(
            self._resolver, where, self._namespace, self._full_name
        )
        return reader.read(items)


def _joined(texts: list[Text], where: SourceLocation) -> Text:
    values = [text.resolved for text in texts]
    known = [value for value in values if value is not None]
    reasons = (text.reason for text in texts if text.resolved is None)
    return Text(
        raw=" ".join(text.raw for text in texts),
        resolved=" ".join(known) if len(known) == len(texts) else None,
        location=where,
        uses=tuple(dict.fromkeys(name for text in texts for name in text.uses)),
        reason=next(reasons, ""),
    )
