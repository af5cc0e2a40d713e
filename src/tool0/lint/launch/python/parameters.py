"""Reads node parameters in a Python launch file: values, commands and files."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Final, final

from tool0.description.packages import source_path
from tool0.errors import DescriptionError, SourceLocation, did_you_mean
from tool0.lint.launch.load_context import is_file, read_limited
from tool0.lint.launch.model import Parameter, Place, Rosparam, Text
from tool0.lint.launch.python.substitution import Resolver, unresolved
from tool0.lint.launch.python.values import Choice, Made, Unknown, Value
from tool0.lint.launch.xacro_files import xacro_call

_VAR: Final = re.compile(r"\$\((?:var|find-pkg-share|env)\s+[^()]*\)")
_ONE_VAR: Final = re.compile(r"\$\(var\s+([^\s()]+)\s*\)")


@final
class ParameterReader:
    """Reads the parameters of one node."""

    def __init__(
        self,
        resolver: Resolver,
        where: SourceLocation,
        namespace: str | None,
        full_name: str | None,
    ) -> None:
        """Prepare to read a node's parameters; the node's name may be unknown."""
        self._resolver, self._where = resolver, where
        self._namespace, self._full_name = namespace, full_name

    def read(self, items: list[Value]) -> tuple[list[Parameter], list[Rosparam]]:
        """Return the single parameters and the parameter files of the node."""
        parameters: list[Parameter] = []
        rosparams: list[Rosparam] = []
        where = self._where
        for item in items:
            match item:
                case dict():
                    self._add_values(item, "", where, parameters)
                case Made(name="Parameter"):
                    pair = {item.get("name"): item.get("value")}
                    self._add_values(pair, "", item.location, parameters)
                case Made(name="ParameterFile"):
                    replaced = item.get("allow_substs") is True
                    file = item.get("param_file")
                    rosparams.append(self._file(file, item.location, replaced))
                case str() | Path() | Made() | list() | tuple():
                    rosparams.append(self._file(item, where, False))
        return parameters, rosparams

    def _place(self, where: SourceLocation) -> Place:
        return replace(self._resolver.state.place(where), namespace=self._namespace)

    def _add_values(
        self,
        values: dict[Value, Value],
        before: str,
        where: SourceLocation,
        parameters: list[Parameter],
    ) -> None:
        for key, value in values.items():
            name = self._resolver.text(key, where)
            if isinstance(value, dict):
                start = f"{before}{name.resolved or name.raw}."
                self._add_values(value, start, where, parameters)
                continue
            parameters.append(self._parameter(before, name, value, where))

    def _parameter(
        self, before: str, name: Text, value: Value, where: SourceLocation
    ) -> Parameter:
        full = None
        if self._full_name is not None and name.resolved is not None:
            full = f"{self._full_name}/{before}{name.resolved}"
        if name.resolved is not None:
            name = replace(name, resolved=before + name.resolved)
        parameter = Parameter(
            place=self._place(where),
            name=name,
            full_name=full,
            source="value",
            content=unresolved("…", "it is unknown", where),
        )
        if isinstance(value, Made) and value.name == "ParameterValue":
            value = value.get("value")
        if isinstance(value, list | tuple) and len(value) == 1:
            value = value[0]
        match value:
            case Made(name="Command"):
                return self._command(parameter, value.get("command"), value.location)
            case Made(name="xacro"):
                mappings = value.get("mappings")
                given = mappings.items() if isinstance(mappings, dict) else ()
                words = [w for k, v in given for w in (" '", k, ":=", v, "'")]
                command = ["xacro '", value.get("file"), "'", *words]
                return self._command(parameter, command, value.location)
            case Made(name="content"):
                content = self._resolver.text(value.get("path"), value.location)
                return replace(parameter, source="textfile", content=content)
            case bool() | int() | float():
                text = Text(raw=str(value), resolved=str(value), location=where)
                return replace(parameter, content=text, type=type(value).__name__)
            case str() | Made() | list() | tuple() | Choice() | Unknown():
                is_list = isinstance(value, list | tuple)
                if not (is_list and _has_numbers(value)):
                    text = self._resolver.text(value, where)
                    return replace(parameter, content=text)
        return parameter

    def _command(
        self, parameter: Parameter, command: Value, where: SourceLocation
    ) -> Parameter:
        content = self._resolver.text(command, where)
        words: tuple[str, ...] = ()
        if content.resolved is not None:
            import shlex

            try:
                words = tuple(shlex.split(content.resolved))
            except ValueError as error:
                self._resolver.report(
                    where,
                    "bad-command",
                    content.resolved.strip()[:40],
                    f"is no command line: {error}",
                    "close the quotation marks",
                )
        parameter = replace(parameter, source="command", content=content, words=words)
        call = xacro_call(parameter)
        if call is not None and call.file is not None and not is_file(call.file):
            self._missing(call.file, where, "xacro")
        return parameter

    def _file(self, value: Value, where: SourceLocation, replaced: bool) -> Rosparam:
        """Return a parameter file."""
        text = self._resolver.text(value, where)
        path, yaml = None, None
        if text.resolved:
            path = source_path(Path(text.resolved))
            if not is_file(path):
                self._missing(path, text.location, "the node")
            else:
                yaml = self._yaml(path, replaced)
        return Rosparam(
            place=self._place(where),
            command="load",
            namespace=self._full_name,
            file=text,
            path=path,
            yaml=yaml,
        )

    def _missing(self, path: Path, where: SourceLocation, user: str) -> None:
        near: list[str] = []
        if path.parent.is_dir():
            near = [p.name for p in path.parent.iterdir() if p.suffix == path.suffix]
        if self._resolver.state.context.packages.package_of(path) is None:
            return  # the file is created at run time, or it is on another machine
        self._resolver.report(
            where,
            "missing-file",
            str(path),
            f"does not exist, and {user} needs it"
            + (did_you_mean(path.name, near) if near else ""),
            "correct the path; it begins in the share folder of a package",
        )

    def _yaml(self, path: Path, replaced: bool) -> Text | None:
        try:
            raw = read_limited(path).decode("utf-8")
        except (DescriptionError, UnicodeDecodeError) as error:
            where = SourceLocation(path)
            self._resolver.report(where, "unreadable-file", str(path), str(error))
            return None
        if not self._resolver.state.context.spend("characters", len(raw)):
            return None
        resolved = _VAR.sub(self._variable, raw) if replaced else raw
        return Text(raw=raw, resolved=resolved, location=SourceLocation(path, 1))

    def _variable(self, match: re.Match[str]) -> str:
        """Return the value of ``$(var NAME)``, or its text if it has no value."""
        one = _ONE_VAR.fullmatch(match[0])
        if one is None:
            return match[0]
        name = {"variable_name": one[1]}
        made = Made("LaunchConfiguration", self._where, name)
        value = self._resolver.text(made, self._where).resolved
        return match[0] if value is None else value


def _has_numbers(items: Value) -> bool:
    """Return whether a list is a parameter value, and not the parts of one text."""
    if not isinstance(items, list | tuple):
        return False
    return all(isinstance(item, str) for item in items) or any(
        isinstance(item, bool | int | float) for item in items
    )
