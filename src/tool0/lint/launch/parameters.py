"""What the parameter server would get of a launch file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from tool0.description.finding import Finding
from tool0.description.yaml_tree import Tree
from tool0.errors import ConfigError, SourceLocation
from tool0.lint.launch import names
from tool0.lint.launch.model import LaunchFile, Parameter, Rosparam


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterValue:
    """One parameter, no namespace."""

    name: str
    """From the root on: ``/arm_controller/type``."""
    value: object
    """None if it is known at run time alone, as what a command prints is."""
    location: SourceLocation


def parameter_values(
    launch: LaunchFile,
) -> tuple[dict[str, ParameterValue], tuple[Finding, ...]]:
    """Return what is set by full name, and what YAML cannot be read.

    The last that sets a parameter counts.  ``delete`` changes nothing: roslaunch
    deletes before it sets.  A few lines of YAML may hold billions of values by aliases:
    a caller who does not trust the files bounds this.
    """
    values: dict[str, ParameterValue] = {}
    findings: list[Finding] = []
    for setting in launch.settings():
        if isinstance(setting, Parameter):
            found = _value(setting)
        else:
            found = _values(setting, findings)
        values.update((value.name, value) for value in found)
    return values, tuple(findings)


def _value(parameter: Parameter) -> Iterator[ParameterValue]:
    if parameter.full_name is None:
        return
    value: object = None
    text = parameter.content.resolved
    if parameter.source == "value" and text is not None:
        value = _converted(text.strip(), parameter.type)
    yield ParameterValue(
        name=parameter.full_name, value=value, location=parameter.place.location
    )


def _converted(text: str, kind: str) -> object:
    match kind:
        case "auto":
            return names.converted(text)
        case "int" | "double":
            try:
                return int(text) if kind == "int" else float(text)
            except ValueError:
                return None
        case "bool" | "boolean":
            return names.as_boolean(text)
        case "yaml":
            try:
                return next(_read(text, SourceLocation(None), named=True)).value
            except (ConfigError, StopIteration):
                return None
    return text


def _values(rosparam: Rosparam, findings: list[Finding]) -> Iterator[ParameterValue]:
    text = None if rosparam.yaml is None else rosparam.yaml.resolved
    if rosparam.yaml is None or text is None or rosparam.namespace is None:
        return
    where = rosparam.yaml.location
    try:
        for value in _read(text, where, named=bool(rosparam.names)):
            joined = names.join(rosparam.namespace, value.name)
            name = names.canonical(joined if value.name else rosparam.namespace)
            yield ParameterValue(name=name, value=value.value, location=value.location)
    except ConfigError as error:
        finding = Finding(
            location=error.location or where, rule="not-yaml", message=error.message
        )
        findings.append(finding)


def _read(
    text: str, location: SourceLocation, *, named: bool
) -> Iterator[ParameterValue]:
    """Yield the values of a YAML text, each named from the text's root on.

    Args:
        text: The YAML.
        location: Where it begins.
        named: Whether it may be a value and no mapping; it is then named ``""``.
    """
    tree = Tree()
    try:
        tree.load(text, location)
    except ConfigError:
        if not named:
            raise
        inside = "\n".join(f" {line}" for line in text.split("\n"))
        line = None if location.line is None else location.line - 1
        tree = Tree()
        tree.load(f"value:\n{inside}", SourceLocation(location.file, line))
        for leaf in tree.root.leaves():
            name = leaf.key.removeprefix("value").removeprefix("/")
            where = leaf.location if name else location
            yield ParameterValue(name=name, value=leaf.plain(), location=where)
        return
    for leaf in tree.root.leaves():
        if leaf.key:
            yield ParameterValue(
                name=leaf.key, value=leaf.plain(), location=leaf.location
            )
