"""Reading what is started, and where: node, test, remap, env and machine."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, cast
from xml.dom.minidom import Element

from tool0.description.xml_source import children
from tool0.errors import DescriptionError
from tool0.lint.launch import grammar
from tool0.lint.launch.model import (
    Activity,
    Node,
    Parameter,
    Rosparam,
    Statement,
    Text,
)
from tool0.lint.launch.params import in_node, read_node_param, read_rosparam
from tool0.lint.launch.scope import Scope

_CONDITIONS = ("if", "unless")
_NODE_KEYS = ("pkg", "type", "name", "args", "ns", "clear_params", "if", "unless")


def read_node(element: Element, scope: Scope) -> Node:
    """Return a ``<node>`` or ``<test>`` with all that holds for it."""
    is_test = element.tagName == "test"
    has_name = element.hasAttribute("name") or not is_test
    name = scope.required(element, "name" if has_name else "test-name")
    outer = scope.namespace_of(element)
    own = None
    if name.resolved and outer is not None:
        own = grammar.as_namespace(grammar.join(outer, name.resolved))
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
            read_statement(child, at)
        elif child.tagName == "env":
            inside.environment.append(read_statement(child, at))
    package = scope.required(element, "pkg")
    _check_package(package, scope)
    args = scope.text(element, "args")
    keys = [key for key, _ in element.attributes.items() if key not in _NODE_KEYS]
    return Node(
        place=replace(scope.place(element), namespace=outer),
        is_test=is_test,
        package=package,
        type=scope.required(element, "type"),
        name=name,
        full_name=None if own is None else own.removesuffix("/"),
        args=args,
        words=() if args is None else scope.words(args),
        settings=tuple((key, scope.required(element, key)) for key in keys),
        parameters=(*(in_node(p, own) for p in scope.private), *parameters),
        rosparams=tuple(rosparams),
        remaps=tuple(inside.remaps),
        environment=tuple(inside.environment),
    )


def _check_package(package: Text, scope: Scope) -> None:
    """Report a node's package that is not here: roslaunch cannot start the node."""
    name, packages = package.resolved, scope.context.packages
    if not name:
        return
    try:
        packages.find(name)
    except DescriptionError:
        near = packages.nearest(name)
        if near is None and not packages.has_ros:
            return  # without ROS no package of ROS is found
        scope.report(
            package.location,
            "missing-package",
            name,
            "is a package that is not found here, and roslaunch cannot start its node"
            + (f"; did you mean '{near}'?" if near else ""),
            f"sudo apt install ros-noetic-{name.replace('_', '-')}, or put the package "
            "into the workspace",
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
    elif name.resolved is not None and not grammar.is_legal(name.resolved):
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


def read_statement(element: Element, scope: Scope) -> Statement:
    """Return a ``<remap>``, ``<env>`` or ``<machine>``.

    A remap holds in the scope from now on, instead of one from the same name.
    """
    kind = cast("Literal['remap', 'env', 'machine']", element.tagName)
    given = [key for key, _ in element.attributes.items() if key not in _CONDITIONS]
    keys = {"remap": ("from", "to"), "env": ("name", "value")}.get(kind, given)
    statement = Statement(
        kind=kind,
        place=scope.place(element),
        texts=tuple((key, scope.required(element, key)) for key in keys),
    )
    if kind == "remap":
        for key, text in statement.texts:
            name = text.resolved
            if name is not None and not (
                name and grammar.is_legal(grammar.canonical(name))
            ):
                message = f"'{name}' is no name that ROS accepts"
                scope.report(text.location, "bad-name", key, message)
        if scope.activity is not Activity.INACTIVE:
            name = statement.subject.resolved
            others = [r for r in scope.remaps if r.subject.resolved != name]
            scope.remaps[:] = [*(scope.remaps if name is None else others), statement]
    return statement
