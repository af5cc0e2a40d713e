"""Reading the elements that set and start things: param, rosparam, node and so on."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal, cast
from xml.dom.minidom import Element

from tool0.description.xml_source import children
from tool0.errors import DescriptionError, SourceLocation
from tool0.launch import grammar, names
from tool0.launch.model import (
    Environment,
    Machine,
    NamedText,
    Node,
    Parameter,
    Remap,
    Rosparam,
)
from tool0.launch.scope import Scope
from tool0.launch.session import is_file, read_bounded
from tool0.launch.text import Activity, Text

_NODE_KEYS = ("pkg", "type", "name", "args", "ns", "clear_params", "if", "unless")
_SOURCES: tuple[Literal["value", "textfile", "binfile", "command"], ...] = (
    "value",
    "textfile",
    "binfile",
    "command",
)
_READERS: dict[str, Callable[[str], object]] = {
    "int": int,
    "double": float,
    "bool": names.as_boolean,
    "boolean": names.as_boolean,
}
_TYPES = ("auto", "str", "string", "int", "double", "bool", "boolean", "yaml")


def read_param(element: Element, scope: Scope) -> Parameter | None:
    """Return a ``<param>`` that stands outside of nodes; private ones are kept."""
    parameter = _param(element, scope)
    if parameter is None:
        return None
    name = parameter.name.resolved
    if name is not None and scope.namespace is not None and name[:1] != "~":
        full_name = names.canonical(names.join(scope.namespace, name))
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
    full_name = names.canonical(namespace + name.removeprefix("~"))
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
        require_file(content, given[0], scope)
    elif given[0] == "value":
        _check_type(content, kind, scope)
    return Parameter(
        place=scope.place(element),
        name=scope.required(element, "name"),
        full_name=None,
        type=kind,
        source=given[0],
        content=content,
        words=split(content, scope) if given[0] == "command" else (),
    )


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


def require_file(text: Text, what: str, scope: Scope) -> None:
    """Report a file that is not there."""
    if text.resolved is None or is_file(text.resolved):
        return
    scope.report(
        text.location,
        "missing-file",
        text.resolved,
        f"does not exist, and {what} needs it",
        "correct the path; $(find PACKAGE)/… begins in a package, $(dirname)/… in the "
        "launch file's folder",
    )


def split(text: Text, scope: Scope) -> tuple[str, ...]:
    """Return the words of a command line."""
    if text.resolved is None:
        return ()
    try:
        return tuple(shlex.split(text.resolved))
    except ValueError as error:
        scope.report(
            text.location,
            "bad-command",
            text.resolved.strip()[:40],
            f"is no command line: {error}",
            "close the quotation marks",
        )
        return ()


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
        full = names.join(full, text.resolved) if text.resolved else full
    return full if full is None or full == "/" else names.canonical(full)


def _yaml(element: Element, file: Text | None, scope: Scope) -> Text | None:
    """Return the YAML that is loaded, as it stands."""
    if file is None:
        parts = [n.nodeValue or "" for n in element.childNodes if n.nodeValue]
        where = SourceLocation(scope.file, scope.session.text_line(scope.file, element))
        raw = "".join(parts)
        return Text(raw=raw, resolved=raw, location=where)
    if file.resolved is None:
        return None
    require_file(file, "rosparam", scope)
    path = Path(file.resolved)
    if not is_file(path) or scope.activity is Activity.INACTIVE:
        return None
    try:
        raw = read_bounded(path).decode("utf-8")
    except (DescriptionError, UnicodeDecodeError) as error:
        scope.report(file.location, "unreadable-file", str(path), str(error))
        return None
    if not scope.session.spend("characters", len(raw)):
        return None
    return Text(raw=raw, resolved=raw, location=SourceLocation(path, 1))


def read_remap(element: Element, scope: Scope) -> Remap:
    """Return a ``<remap>``."""
    remap = Remap(
        place=scope.place(element),
        from_name=scope.required(element, "from"),
        to_name=scope.required(element, "to"),
    )
    for key, text in remap.texts:
        name = text.resolved
        if name is not None and (not name or not names.is_legal(names.canonical(name))):
            scope.report(
                text.location, "bad-name", key, f"'{name}' is no name that ROS accepts"
            )
    return remap


def hold(remap: Remap, remaps: list[Remap]) -> None:
    """Put ``remap`` into ``remaps``, in place of one from the same name."""
    if remap.place.activity is Activity.INACTIVE:
        return
    name = remap.from_name.resolved
    remaps[:] = [r for r in remaps if name is None or r.from_name.resolved != name]
    remaps.append(remap)


def read_env(element: Element, scope: Scope) -> Environment:
    """Return an ``<env>``."""
    return Environment(
        place=scope.place(element),
        name=scope.required(element, "name"),
        value=scope.required(element, "value"),
    )


def read_machine(element: Element, scope: Scope) -> Machine:
    """Return a ``<machine>``."""
    keys = [key for key, _ in element.attributes.items() if key not in ("if", "unless")]
    texts = [(key, scope.required(element, key)) for key in keys]
    return Machine(place=scope.place(element), settings=tuple(texts))


def namespace_of(element: Element, scope: Scope) -> str | None:
    """Return the namespace that an element's ``ns`` opens, in that of the scope."""
    text = scope.text(element, "ns")
    clears = scope.boolean(element, "clear_params")
    is_node = element.tagName in ("node", "test")
    if clears and not is_node and not (text is not None and text.raw):
        scope.report(
            scope.locate(element),
            "bad-value",
            "clear_params",
            "needs ns beside it, to say which parameters go",
            'write ns="…"',
        )
    if text is None:
        return scope.namespace
    if text.resolved == "":
        scope.report(
            text.location,
            "bad-value",
            "ns",
            "is empty: roslaunch stops here",
            "remove it, or name a namespace",
        )
        return scope.namespace
    if text.resolved is None or scope.namespace is None:
        return None
    return names.as_namespace(names.join(scope.namespace, text.resolved))


def read_node(element: Element, scope: Scope) -> Node:
    """Return a ``<node>`` or ``<test>`` with all that holds for it."""
    is_test = element.tagName == "test"
    has_name = element.hasAttribute("name") or not is_test
    name = scope.required(element, "name" if has_name else "test-name")
    outer = namespace_of(element, scope)
    own = None
    if name.resolved and outer is not None:
        own = names.as_namespace(names.join(outer, name.resolved))
    _check_node(element, name, scope)
    inside = replace(
        scope,
        namespace=own,
        private=[],
        remaps=list(scope.remaps),
        environment=list(scope.environment),
    )
    parameters: list[Parameter] = []
    rosparams: list[Rosparam] = []
    for child in children(element):
        if child.tagName not in grammar.CHILDREN["node"]:
            continue
        at = inside.at(child)
        grammar.check(child, scope.locate(child), scope.findings.append)
        if child.tagName == "param" and (param := read_node_param(child, at)):
            parameters.append(param)
        elif child.tagName == "rosparam" and (rosparam := read_rosparam(child, at)):
            rosparams.append(rosparam)
        elif child.tagName == "remap":
            hold(read_remap(child, at), inside.remaps)
        elif child.tagName == "env":
            inside.environment.append(read_env(child, at))
    args = scope.text(element, "args")
    keys = [key for key, _ in element.attributes.items() if key not in _NODE_KEYS]
    return Node(
        place=replace(scope.place(element), namespace=outer),
        is_test=is_test,
        package=scope.required(element, "pkg"),
        type=scope.required(element, "type"),
        name=name,
        full_name=None if own is None else own.removesuffix("/"),
        args=args,
        words=() if args is None else split(args, scope),
        settings=tuple((key, scope.required(element, key)) for key in keys),
        parameters=(*(in_node(p, own) for p in scope.private), *parameters),
        rosparams=tuple(rosparams),
        remaps=tuple(inside.remaps),
        environment=tuple(inside.environment),
    )


def _check_node(element: Element, name: Text, scope: Scope) -> None:
    """Report what roslaunch refuses in a node."""
    where = scope.locate(element)
    if name.resolved is not None and "/" in name.resolved:
        scope.report(
            where,
            "bad-name",
            name.resolved,
            "is a node's name with a namespace in it: roslaunch stops here",
            "write the namespace into ns",
        )
    elif name.resolved is not None and not names.is_legal(name.resolved):
        scope.report(
            where,
            "bad-name",
            name.resolved,
            "is no name that ROS accepts for a node",
            "use letters, digits and underscores, a letter first",
        )
    respawn, required = (scope.boolean(element, k) for k in ("respawn", "required"))
    if respawn and required:
        scope.report(
            where,
            "bad-value",
            "respawn",
            "and required are both true: roslaunch stops here",
            "remove one of them",
        )
    for key, valid in (("output", ("log", "screen")), ("cwd", ("ROS_HOME", "node"))):
        text = scope.text(element, key)
        word = None if text is None else text.resolved
        if word is not None and word.lower() not in [v.lower() for v in valid]:
            scope.report(
                where, "bad-value", key, f"must be {' or '.join(valid)}, not '{word}'"
            )
