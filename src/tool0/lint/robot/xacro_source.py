"""Rules for a xacro file as it is written: includes, macros, prefixes, interfaces."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import final
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at, short, warning_at
from tool0.description.xml_source import children, text_of
from tool0.lint.packages import PackageIndex, nearest_file
from tool0.lint.robot.elements import attribute, descendants, place
from tool0.lint.robot.interfaces import is_interface, meant_interface

# As xacro reads them: a name, perhaps := or = and a value, which may be quoted.
_PARAMETER = re.compile(
    r"\s*([^\s:=]+?)(?:\s*(?::=|=)\s*(\^\|)?(?:'([^']*)'|\"([^\"]*)\"|(\S*)))?(?:\s+|$)"
)
_FIND = re.compile(r"\$\(find\s+([^\s)]+)\s*\)")
_TRUE = ("true", "1")
_PATTERN = re.compile(r"[*?\[]")
"""xacro includes every file that matches, or none."""
_WORD = re.compile(r"[^\W\d]\w*")
_OUTER = "^"
"""The default that means: what the calling macro calls so."""
_PREFIX = "prefix"
_LIKE = re.compile(r"interf|hardware", re.IGNORECASE)


@final
@dataclass(frozen=True, slots=True)
class MacroParameter:
    """One parameter of a macro: ``name`` or ``name:=default``."""

    name: str
    """Without the stars of a block."""
    default: str | None
    is_block: bool


def macros_of(root: Element) -> Iterator[Element]:
    """Yield the <xacro:macro> elements, those inside others too."""
    for element in descendants(root):
        if element.tagName == "xacro:macro":
            yield element


def own_elements(macro: Element) -> Iterator[Element]:
    """Yield what is in ``macro``, without macros inside that take the same names."""
    names = {parameter.name for parameter in parameters_of(macro)}
    waiting = [macro]
    while waiting:
        element = waiting.pop()
        if element is not macro:
            if element.tagName == "xacro:macro" and names & {
                parameter.name for parameter in parameters_of(element)
            }:
                continue
            yield element
        waiting.extend(reversed(list(children(element))))


def parameters_of(macro: Element) -> tuple[MacroParameter, ...]:
    """Return the parameters of ``macro``; what makes no sense is left out."""
    text = macro.getAttribute("params")
    found = []
    at = 0
    while at < len(text):
        match = _PARAMETER.match(text, at)
        if match is None or match.end() == at:
            break
        at = match.end()
        name, _, *values = match.groups()
        default = next((value for value in values if value is not None), None)
        found.append(MacroParameter(name.lstrip("*"), default, name.startswith("*")))
    return tuple(found)


def include_findings(root: Element, known: Mapping[str, Path]) -> Iterator[Finding]:
    """Yield the includes of files that do not exist."""
    packages = PackageIndex(known)
    named: set[str] = set()
    for element in descendants(root):
        if element.tagName != "xacro:include":
            continue
        text = attribute(element, "filename")
        missing = [name for name in _FIND.findall(text) if packages.get(name) is None]
        for name in missing:
            if name not in named:
                named.add(name)
                yield packages.unknown(name, "an <xacro:include>", place(element))
        if not missing and attribute(element, "optional").lower() not in _TRUE:
            yield from _missing(element, text, packages)


def included_files(root: Element, known: Mapping[str, Path]) -> Iterator[Path]:
    """Yield the files that a xacro file includes, whatever its arguments are."""
    packages = PackageIndex(known)
    for element in descendants(root):
        if element.tagName == "xacro:include":
            path = _included(element, attribute(element, "filename"), packages)
            if path is not None:
                yield path


def _included(element: Element, text: str, packages: PackageIndex) -> Path | None:
    """Return the file that an include is about, if it is always the same."""
    location = place(element)
    folder = Path() if location.file is None else location.file.parent
    filled = _FIND.sub(lambda match: str(packages.get(match.group(1))), text)
    filled = filled.replace("$(dirname)", str(folder))
    if "$" in filled or _PATTERN.search(text):
        return None
    return folder / filled  # an absolute one stays as it is


def _missing(element: Element, text: str, packages: PackageIndex) -> Iterator[Finding]:
    location, path = place(element), _included(element, text, packages)
    if path is None:
        return
    if text and os.path.isfile(path):  # noqa: PTH113  # Path.is_file may raise
        return
    close = nearest_file(path)
    yield error_at(
        location,
        "missing-include",
        text,
        f"there is no file '{short(str(path))}' to include, so xacro fails, and "
        "robot_description stays empty",
        f"there is '{close}'; write that" if close else "check the path",
    )


def parameter_findings(root: Element) -> Iterator[Finding]:
    """Yield unused parameters, and arguments that are declared twice."""
    yield from _unused(root)
    yield from _declared_twice(root)


def _unused(root: Element) -> Iterator[Finding]:
    # A macro sees what its caller has, so that a use anywhere in the file counts.
    used = set(_used_words(root))
    for macro in macros_of(root):
        for parameter in parameters_of(macro):
            if parameter.name in used or not parameter.name:
                continue
            name = macro.getAttribute("name")
            yield warning_at(
                place(macro),
                "unused-parameter",
                parameter.name,
                f"macro '{short(name)}' takes '{short(parameter.name)}', which "
                "nothing in this file uses: whatever is given for it does nothing",
                (
                    f'use <xacro:insert_block name="{parameter.name}"/>'
                    if parameter.is_block
                    else f"use it, as ${{{short(parameter.name)}}}"
                )
                + ", or take it out of params",
            )


def _used_words(root: Element) -> Iterator[str]:
    for element in descendants(root):
        if element.tagName == "xacro:insert_block":
            yield attribute(element, "name")
        if element.tagName == "xacro:macro":
            for parameter in parameters_of(element):
                if parameter.default == _OUTER:
                    yield parameter.name
        values = (value for _, value in element.attributes.items())
        for text in (text_of(element), *values):
            if "$" in text:
                yield from _WORD.findall(text)


def _declared_twice(root: Element) -> Iterator[Finding]:
    first: dict[str, Element] = {}
    for element in children(root, "xacro:arg"):
        name, default = attribute(element, "name"), attribute(element, "default")
        earlier = first.setdefault(name, element)
        if earlier is element or attribute(earlier, "default") == default:
            continue
        yield warning_at(
            place(element),
            "duplicate-arg",
            name,
            f"the argument '{short(name)}' is declared again with the default "
            f"'{short(default)}', which does nothing: the first counts, "
            f"'{short(attribute(earlier, 'default'))}' at {place(earlier)}",
            "remove one of the two",
        )


def call_findings(root: Element) -> Iterator[Finding]:
    """Yield the calls in macros with a prefix that hand on an empty one."""
    for macro in macros_of(root):
        prefixes = {
            parameter.name
            for parameter in parameters_of(macro)
            if parameter.name.endswith(_PREFIX)
        }
        if not prefixes:
            continue
        for call in own_elements(macro):
            for prefix in sorted(prefixes):
                if call.tagName.startswith("xacro:") and _is_empty(call, prefix):
                    yield _hard_coded(macro, call, prefix)


def _is_empty(call: Element, prefix: str) -> bool:
    return call.hasAttribute(prefix) and call.getAttribute(prefix).strip() in {
        "",
        "''",
        "${''}",
        '${""}',
    }


def _hard_coded(macro: Element, call: Element, prefix: str) -> Finding:
    outer, inner = macro.getAttribute("name"), call.tagName
    return error_at(
        place(call),
        "hardcoded-prefix",
        outer,
        f"macro '{short(outer)}' takes a {prefix}, yet hands an empty one to "
        f"<{short(inner)}>: what that makes never has a prefix, so a second one "
        "in the same robot collides, and so does a base_link of both",
        f'write <{short(inner)} {prefix}="${{{prefix}}}" …>',
    )


def interface_findings(root: Element) -> Iterator[Finding]:
    """Yield the misspelt interfaces that are written out in a xacro file."""
    for element in descendants(root):
        for name, text in _values(element):
            if "$" in text or not _LIKE.search(text) or is_interface(text):
                continue
            meant = meant_interface(text)
            if meant:
                yield _typo(element, name, text, meant)


def _values(element: Element) -> Iterator[tuple[str, str]]:
    """Yield what ``element`` gives values to, and the values."""
    tag = element.tagName
    if tag == "hardwareInterface":
        yield "", text_of(element)
    elif tag == "xacro:macro":
        for parameter in parameters_of(element):
            yield parameter.name, parameter.default or ""
    elif tag in {"xacro:arg", "xacro:property"}:
        for key in ("default", "value"):
            yield attribute(element, "name"), attribute(element, key)
    elif tag.startswith("xacro:"):
        for key, value in element.attributes.items():
            if key not in {"filename", "file", "name"}:
                yield key, value.strip()


def _typo(element: Element, name: str, text: str, meant: str) -> Finding:
    of = f" of '{short(name)}'" if name else ""
    kind = "default" if element.tagName in {"xacro:macro", "xacro:arg"} else "value"
    return error_at(
        place(element),
        "interface-typo",
        name or text,
        f"the {kind} '{short(text)}'{of} is no hardware interface: "
        "gazebo_ros_control stops at a joint that gets it, and no controller runs",
        f"write {meant}",
    )
