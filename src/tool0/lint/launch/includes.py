"""What an ``<include>`` asks for: which file, with which arguments."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final
from xml.dom.minidom import Element

from tool0.description.xml_source import children
from tool0.lint.launch import grammar
from tool0.lint.launch.arguments import Given
from tool0.lint.launch.attributes import namespace_of, require_file
from tool0.lint.launch.model import Environment, Include, NamedText, Passed
from tool0.lint.launch.node_elements import read_env
from tool0.lint.launch.scope import Scope
from tool0.lint.launch.session import is_file
from tool0.lint.launch.text import Activity, Text


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """What an include asks for."""

    include: Include
    path: Path
    given: Mapping[str, Given]
    environment: tuple[Environment, ...]

    @property
    def key(self) -> frozenset[tuple[str, str | None]]:
        """The arguments as a value, by which a file's reading is known again."""
        return frozenset((name, g.text.resolved) for name, g in self.given.items())


def target_of(element: Element, scope: Scope) -> Target:
    """Return what an ``<include>`` asks for."""
    file = scope.required(element, "file")
    namespace = namespace_of(element, scope)
    passes_all = scope.boolean(element, "pass_all_args")
    given = _all_given(element, scope) if passes_all else {}
    passed, environment = _children(element, scope, given, passes_all=passes_all)
    path = Path(os.path.normpath(file.resolved)) if file.resolved else None
    settings: tuple[NamedText, ...] = tuple(
        (key, scope.required(element, key))
        for key in ("ns",)
        if element.hasAttribute(key)
    )
    include = Include(
        place=replace(scope.place(element), namespace=namespace),
        file=file,
        path=path,
        passed=passed,
        passes_all=passes_all,
        settings=settings,
        reason=_reason(file, path, scope),
    )
    return Target(
        include=include,
        path=(path or Path()).absolute(),
        given=given,
        environment=environment,
    )


def _reason(file: Text, path: Path | None, scope: Scope) -> str:
    """Return why there is nothing to include, if so; report it."""
    if path is None:
        return file.reason or "no file is named"
    require_file(file, "include", scope)
    return "" if is_file(path) else f"{path} does not exist"


def _all_given(element: Element, scope: Scope) -> dict[str, Given]:
    """Return the arguments of the file as pass_all_args passes them."""
    where = scope.locate(element)
    scope.used.update(scope.declared, scope.values)
    given = {}
    for name in {**scope.declared, **scope.values}:
        text = scope.values.get(name)
        given[name] = Given(
            text=Text(
                raw=f"$(arg {name})",
                resolved=None if text is None else text.resolved,
                location=where,
                uses=(name,),
                reason=f"argument '{name}' has no value"
                if text is None
                else text.reason,
            ),
            origin="pass_all_args",
        )
    return given


def _children(
    element: Element, scope: Scope, given: dict[str, Given], *, passes_all: bool
) -> tuple[tuple[Passed, ...], tuple[Environment, ...]]:
    """Read what stands in the include; add the arguments to ``given``."""
    passed: list[Passed] = []
    environment: list[Environment] = []
    names: set[str] = set()
    for child in children(element):
        if child.tagName not in grammar.CHILDREN["include"]:
            continue
        at = scope.at(child)
        grammar.check(child, scope.locate(child), scope.findings.append)
        if child.tagName == "env":
            environment.append(read_env(child, at))
            continue
        name = at.required(child, "name").resolved
        if not name:
            continue
        value = at.text(child, "value")
        text = at.text(child, "default") if value is None else value
        passed.append(Passed(name=name, place=at.place(child), value=text))
        if at.activity is Activity.INACTIVE:
            continue
        if name in names and at.activity is Activity.ACTIVE and not passes_all:
            at.report(
                at.locate(child),
                "duplicate-argument",
                name,
                "is given twice in one <include>: roslaunch stops here",
                "remove one of them",
            )
        names.add(name)
        if text is not None and (value is not None or name not in given):
            given[name] = Given(text=text, origin="include")
        elif text is None and name not in given:
            at.report(
                at.locate(child),
                "missing-argument",
                name,
                "is passed to an include without a value: roslaunch stops here",
                f'write value="…", such as value="$(arg {name})"',
            )
    return tuple(passed), tuple(environment)
