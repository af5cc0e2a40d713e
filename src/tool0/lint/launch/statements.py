"""Reads the statements of a launch file, such as nodes, parameters and remaps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal, cast

from tool0.errors import DescriptionError, SourceLocation
from tool0.lint.launch import grammar
from tool0.lint.launch.load_context import is_file, read_limited
from tool0.lint.launch.model import (
    NamedText,
    Node,
    Parameter,
    Rosparam,
    Statement,
    Text,
)
from tool0.lint.launch.scope import Scope
from tool0.lint.launch.xacro_files import xacro_call

_Source = Literal["value", "textfile", "binfile", "command"]
_SOURCES: tuple[_Source, ...] = ("value", "textfile", "binfile", "command")
_READERS: dict[str, Callable[[str], object]] = {
    "int": int,
    "double": float,
    "bool": grammar.as_boolean,
    "boolean": grammar.as_boolean,
}
_CONDITIONS = ("if", "unless")
_NODE_KEYS = ("pkg", "type", "name", "args", "ns", "clear_params", "if", "unless")
_TYPES = ("auto", "str", "string", "int", "double", "bool", "boolean", "yaml")


def read_param(scope: Scope) -> Parameter | None:
    """Return a ``<param>`` outside nodes.  Store private parameters for later nodes."""
    parameter = _param(scope)
    if parameter is None:
        return None
    name = parameter.name.resolved
    if name is not None and scope.namespace is not None and name[:1] != "~":
        full_name = grammar.canonical(grammar.join(scope.namespace, name))
        return replace(parameter, full_name=full_name)
    if parameter.is_private and scope.holds is not False:
        before = [p for p in scope.private if p.name.resolved != name]
        scope.private[:] = [*before, parameter]
    return parameter


def _in_node(parameter: Parameter, namespace: str | None) -> Parameter:
    """Return ``parameter`` with the name that it has in a node in ``namespace``."""
    name = parameter.name.resolved
    if name is None or namespace is None:
        return parameter
    full_name = grammar.canonical(namespace + name.removeprefix("~"))
    return replace(parameter, full_name=full_name)


def _param(scope: Scope) -> Parameter | None:
    given = [source for source in _SOURCES if scope.element.hasAttribute(source)]
    if len(given) != 1:
        has = f"has {', '.join(given)}" if given else "has none of them"
        scope.report(
            "bad-param",
            scope.element.getAttribute("name"),
            f"{has}, and needs one of value, textfile, binfile and command: "
            "roslaunch stops here",
            "leave one of them",
        )
        if not given:
            return None
    kind = (scope.element.getAttribute("type") or "auto").lower().strip()
    if kind not in _TYPES:
        scope.report(
            "bad-value",
            "type",
            f"'{kind}' is no type of parameters; valid: {', '.join(_TYPES)}",
        )
    content = scope.required(given[0])
    if given[0] in ("textfile", "binfile"):
        scope.require_file(content, given[0])
    elif given[0] == "value":
        _check_type(content, kind, scope)
    parameter = Parameter(
        place=scope.place,
        name=scope.required("name"),
        full_name=None,
        type=kind,
        source=given[0],
        content=content,
        words=scope.words(content) if given[0] == "command" else (),
    )
    call = xacro_call(parameter)
    if call is not None and call.file is not None:
        scope.require_file(replace(content, resolved=str(call.file)), "xacro")
    return parameter


def _check_type(content: Text, kind: str, scope: Scope) -> None:
    if content.resolved is None or kind not in _READERS:
        return
    try:
        is_right = _READERS[kind](content.resolved.strip()) is not None
    except ValueError:
        is_right = False
    if not is_right:
        scope.report(
            "bad-value",
            "value",
            f"'{content.resolved}' is no {kind}, the type: roslaunch stops here",
            "correct the value or the type",
        )


def read_rosparam(scope: Scope) -> Rosparam | None:
    """Return a ``<rosparam>``."""
    command = scope.text("command")
    verb = "load" if command is None else command.resolved or "load"
    if verb not in ("load", "delete", "dump"):
        scope.report("bad-value", "command", f"'{verb}' is not load, delete or dump")
        return None
    file = scope.text("file")
    if verb == "delete" and file is not None:
        scope.report("bad-value", "file", "has no meaning with delete", "remove it")
    substitutes = scope.boolean("subst_value")
    named = [(key, scope.text(key)) for key in ("ns", "param")]
    texts: tuple[NamedText, ...] = tuple((k, t) for k, t in named if t is not None)
    yaml = None
    if verb == "load":
        yaml = _yaml(file, scope)
        if yaml is not None and substitutes:
            yaml = scope.resolved(yaml.raw, yaml.location)
    return Rosparam(
        place=scope.place,
        command=cast("Literal['load', 'delete', 'dump']", verb),
        namespace=_rosparam_namespace(texts, scope),
        file=file,
        path=Path(file.resolved) if file is not None and file.resolved else None,
        yaml=yaml,
        names=texts,
    )


def _rosparam_namespace(texts: tuple[NamedText, ...], scope: Scope) -> str | None:
    full: str | None = scope.namespace
    for _, text in texts:
        if full is None or text.resolved is None:
            return None
        full = grammar.join(full, text.resolved) if text.resolved else full
    return full if full is None or full == "/" else grammar.canonical(full)


def _yaml(file: Text | None, scope: Scope) -> Text | None:
    """Return the loaded YAML as it is written."""
    if file is None:
        parts = [n.nodeValue or "" for n in scope.element.childNodes if n.nodeValue]
        where = SourceLocation(
            scope.file, scope.context.text_line(scope.file, scope.element)
        )
        raw = "".join(parts)
        return Text(raw=raw, resolved=raw, location=where)
    if file.resolved is None:
        return None
    scope.require_file(file, "rosparam")
    path = Path(file.resolved)
    if not is_file(path) or scope.holds is False:
        return None
    try:
        raw = read_limited(path).decode("utf-8")
    except (DescriptionError, UnicodeDecodeError) as error:
        scope.report("unreadable-file", str(path), str(error))
        return None
    if not scope.context.spend("characters", len(raw)):
        return None
    return Text(raw=raw, resolved=raw, location=SourceLocation(path, 1))


def read_node(scope: Scope) -> Node:
    """Return a ``<node>`` or ``<test>`` with its parameters, remaps and environment."""
    is_test = scope.tag == "test"
    has_name = scope.element.hasAttribute("name") or not is_test
    name = scope.required("name" if has_name else "test-name")
    outer = scope.inner_namespace()
    own = None
    if name.resolved and outer is not None:
        own = grammar.as_namespace(grammar.join(outer, name.resolved))
    _check_node(name, scope)
    inside = replace(
        scope,
        namespace=own,
        private=[],
        remaps=list(scope.remaps),
        environment=list(scope.environment),
    )
    parameters: list[Parameter] = []
    rosparams: list[Rosparam] = []
    for at in inside.children():
        if at.tag == "param" and (parameter := _param(at)):
            parameters.append(_in_node(parameter, own))
        elif at.tag == "rosparam" and (rosparam := read_rosparam(at)):
            rosparams.append(rosparam)
        elif at.tag == "remap":
            read_statement(at)
        elif at.tag == "env":
            inside.environment.append(read_statement(at))
    package = scope.required("pkg")
    _check_package(package, scope)
    args = scope.text("args")
    keys = [key for key, _ in scope.element.attributes.items() if key not in _NODE_KEYS]
    return Node(
        place=replace(scope.place, namespace=outer),
        is_test=is_test,
        package=package,
        type=scope.required("type"),
        name=name,
        full_name=None if own is None else own.removesuffix("/"),
        args=args,
        words=() if args is None else scope.words(args),
        settings=tuple((key, scope.required(key)) for key in keys),
        parameters=(*(_in_node(p, own) for p in scope.private), *parameters),
        rosparams=tuple(rosparams),
        remaps=tuple(inside.remaps),
        environment=tuple(inside.environment),
    )


def _check_package(package: Text, scope: Scope) -> None:
    """Report a missing package, because roslaunch cannot start the package's node."""
    name, packages = package.resolved, scope.context.packages
    if not name:
        return
    try:
        packages.find(name)
    except DescriptionError:
        near = packages.nearest(name)
        if near is None and not packages.has_ros:
            return  # without ROS, ROS packages are never found
        scope.report(
            "missing-package",
            name,
            "is a package that is not found here, and roslaunch cannot start its node"
            + (f"; did you mean '{near}'?" if near else ""),
            f"sudo apt install ros-noetic-{name.replace('_', '-')}, or put the package "
            "into the workspace",
        )


def _check_node(name: Text, scope: Scope) -> None:
    """Report attributes of a node that roslaunch refuses."""
    if name.resolved is not None and "/" in name.resolved:
        scope.report(
            "bad-name",
            name.resolved,
            "is a node's name with a namespace in it: roslaunch stops here",
            "write the namespace into ns",
        )
    elif name.resolved is not None and not grammar.is_legal(name.resolved):
        scope.report(
            "bad-name",
            name.resolved,
            "is no name that ROS accepts for a node",
            "use letters, digits and underscores, a letter first",
        )
    respawn, required = (scope.boolean(k) for k in ("respawn", "required"))
    if respawn and required:
        scope.report(
            "bad-value",
            "respawn",
            "and required are both true: roslaunch stops here",
            "remove one of them",
        )
    for key, valid in (("output", ("log", "screen")), ("cwd", ("ROS_HOME", "node"))):
        text = scope.text(key)
        word = None if text is None else text.resolved
        if word is not None and word.lower() not in [v.lower() for v in valid]:
            scope.report(
                "bad-value", key, f"must be {' or '.join(valid)}, not '{word}'"
            )


def read_statement(scope: Scope) -> Statement:
    """Return a ``<remap>``, ``<env>`` or ``<machine>``.

    A remap applies to all later entries in the scope, and it replaces an earlier remap
    of the same name.
    """
    kind = cast("Literal['remap', 'env', 'machine']", scope.tag)
    given = [
        key for key, _ in scope.element.attributes.items() if key not in _CONDITIONS
    ]
    keys = {"remap": ("from", "to"), "env": ("name", "value")}.get(kind, given)
    statement = Statement(
        kind=kind,
        place=scope.place,
        texts=tuple((key, scope.required(key)) for key in keys),
    )
    if kind == "remap":
        for key, text in statement.texts:
            name = text.resolved
            if name is not None and not (
                name and grammar.is_legal(grammar.canonical(name))
            ):
                message = f"'{name}' is no name that ROS accepts"
                scope.report("bad-name", key, message)
        if scope.holds is not False:
            name = statement.subject.resolved
            others = [r for r in scope.remaps if r.subject.resolved != name]
            scope.remaps[:] = [*(scope.remaps if name is None else others), statement]
    return statement
