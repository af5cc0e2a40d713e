"""Reading ``<param>`` and ``<rosparam>``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal, cast
from xml.dom.minidom import Element

from tool0.errors import DescriptionError, SourceLocation
from tool0.lint.launch import grammar
from tool0.lint.launch.load_context import is_file, read_limited
from tool0.lint.launch.model import (
    Activity,
    NamedText,
    Parameter,
    Rosparam,
    Text,
)
from tool0.lint.launch.scope import Scope
from tool0.lint.launch.xacro_files import xacro_call

_SOURCES: tuple[Literal["value", "textfile", "binfile", "command"], ...] = (
    "value",
    "textfile",
    "binfile",
    "command",
)
_READERS: dict[str, Callable[[str], object]] = {
    "int": int,
    "double": float,
    "bool": grammar.as_boolean,
    "boolean": grammar.as_boolean,
}
_TYPES = ("auto", "str", "string", "int", "double", "bool", "boolean", "yaml")


def read_param(element: Element, scope: Scope) -> Parameter | None:
    """Return a ``<param>`` that stands outside of nodes; private ones are kept."""
    parameter = _param(element, scope)
    if parameter is None:
        return None
    name = parameter.name.resolved
    if name is not None and scope.namespace is not None and name[:1] != "~":
        full_name = grammar.canonical(grammar.join(scope.namespace, name))
        return replace(parameter, full_name=full_name)
    if parameter.is_private and scope.activity is not Activity.INACTIVE:
        before = [p for p in scope.private if p.name.resolved != name]
        scope.private[:] = [*before, parameter]
    return parameter


def read_node_param(element: Element, scope: Scope) -> Parameter | None:
    """Return a ``<param>`` in a node, whose namespace the scope has."""
    parameter = _param(element, scope)
    return None if parameter is None else in_node(parameter, scope.namespace)


def in_node(parameter: Parameter, namespace: str | None) -> Parameter:
    """Return ``parameter`` as the node in ``namespace`` gets it."""
    name = parameter.name.resolved
    if name is None or namespace is None:
        return parameter
    full_name = grammar.canonical(namespace + name.removeprefix("~"))
    return replace(parameter, full_name=full_name)


def _param(element: Element, scope: Scope) -> Parameter | None:
    given = [source for source in _SOURCES if element.hasAttribute(source)]
    where = scope.locate(element)
    if len(given) != 1:
        has = f"has {', '.join(given)}" if given else "has none of them"
        scope.report(
            where,
            "bad-param",
            element.getAttribute("name"),
            f"{has}, and needs one of value, textfile, binfile and command: "
            "roslaunch stops here",
            "leave one of them",
        )
        if not given:
            return None
    kind = (element.getAttribute("type") or "auto").lower().strip()
    if kind not in _TYPES:
        scope.report(
            where,
            "bad-value",
            "type",
            f"'{kind}' is no type of parameters; valid: {', '.join(_TYPES)}",
        )
    content = scope.required(element, given[0])
    if given[0] in ("textfile", "binfile"):
        scope.require_file(content, given[0])
    elif given[0] == "value":
        _check_type(content, kind, scope)
    parameter = Parameter(
        place=scope.place(element),
        name=scope.required(element, "name"),
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
            content.location,
            "bad-value",
            "value",
            f"'{content.resolved}' is no {kind}, as type says: roslaunch stops here",
            "correct the value or the type",
        )


def read_rosparam(element: Element, scope: Scope) -> Rosparam | None:
    """Return a ``<rosparam>``."""
    where = scope.locate(element)
    command = scope.text(element, "command")
    verb = "load" if command is None else command.resolved or "load"
    if verb not in ("load", "delete", "dump"):
        scope.report(
            where, "bad-value", "command", f"'{verb}' is not load, delete or dump"
        )
        return None
    file = scope.text(element, "file")
    if verb == "delete" and file is not None:
        scope.report(
            where, "bad-value", "file", "has no meaning with delete", "remove it"
        )
    substitutes = scope.boolean(element, "subst_value")
    named = [(key, scope.text(element, key)) for key in ("ns", "param")]
    texts: tuple[NamedText, ...] = tuple((k, t) for k, t in named if t is not None)
    yaml = None
    if verb == "load":
        yaml = _yaml(element, file, scope)
        if yaml is not None and substitutes:
            yaml = scope.resolved(yaml.raw, yaml.location)
    return Rosparam(
        place=scope.place(element),
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


def _yaml(element: Element, file: Text | None, scope: Scope) -> Text | None:
    """Return the YAML that is loaded, as it stands."""
    if file is None:
        parts = [n.nodeValue or "" for n in element.childNodes if n.nodeValue]
        where = SourceLocation(scope.file, scope.context.text_line(scope.file, element))
        raw = "".join(parts)
        return Text(raw=raw, resolved=raw, location=where)
    if file.resolved is None:
        return None
    scope.require_file(file, "rosparam")
    path = Path(file.resolved)
    if not is_file(path) or scope.activity is Activity.INACTIVE:
        return None
    try:
        raw = read_limited(path).decode("utf-8")
    except (DescriptionError, UnicodeDecodeError) as error:
        scope.report(file.location, "unreadable-file", str(path), str(error))
        return None
    if not scope.context.spend("characters", len(raw)):
        return None
    return Text(raw=raw, resolved=raw, location=SourceLocation(path, 1))
