"""Rules for a xacro file before expansion: includes, macros, prefixes, interfaces."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import final

from tool0.description.finding import Finding, error_at, short, warning_at
from tool0.description.packages import source_path
from tool0.lint.packages import PackageIndex, nearest_file
from tool0.lint.robot.elements import Tag
from tool0.lint.robot.facts import is_interface, meant_interface

# The pattern follows xacro's own rules: a name, which may be followed by := or = and a
# value.  The value may be quoted.
_PARAMETER = re.compile(
    r"\s*([^\s:=]+?)(?:\s*(?::=|=)\s*(\^\|)?(?:'([^']*)'|\"([^\"]*)\"|(\S*)))?(?:\s+|$)"
)
_FIND = re.compile(r"\$\(find\s+([^\s)]+)\s*\)")
_TRUE = ("true", "1")
_PATTERN = re.compile(r"[*?\[]")
"""Wildcards of an include. xacro includes all matching files, if there are any."""
_WORD = re.compile(r"[^\W\d]\w*")
_OUTER = "^"
"""Default value that refers to the parameter of the same name in the calling macro."""
_EMPTY = ("", "''", "${''}", '${""}')
_MACRO = "xacro:macro"
_LIKE = re.compile(r"interf|hardware", re.IGNORECASE)


@final
@dataclass(frozen=True, slots=True)
class MacroParameter:
    """One parameter of a macro, written as ``name`` or ``name:=default``."""

    name: str
    """Name of the parameter, without the asterisks that mark a block."""
    default: str | None
    is_block: bool


def own_tags(macro: Tag) -> Iterator[Tag]:
    """Yield elements in ``macro``, except inner macros that redefine a parameter."""
    names = {parameter.name for parameter in parameters_of(macro)}
    waiting = [macro]
    while waiting:
        tag = waiting.pop()
        if tag is not macro:
            if tag.tag == _MACRO and names & {p.name for p in parameters_of(tag)}:
                continue
            yield tag
        waiting.extend(reversed(list(tag.children())))


def parameters_of(macro: Tag) -> tuple[MacroParameter, ...]:
    """Return the well-formed parameters of ``macro``."""
    text = macro.written("params")
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


def include_findings(root: Tag, packages: PackageIndex) -> Iterator[Finding]:
    """Yield the includes of files that do not exist."""
    named: set[str] = set()
    for tag in root.descendants("xacro:include"):
        text = tag["filename"]
        names = [name for name in _FIND.findall(text) if "${" not in name]
        missing = [name for name in names if packages.get(name) is None]
        for name in missing:
            if name not in named:
                named.add(name)
                yield packages.unknown(name, "an <xacro:include>", tag.location)
        path = _included(tag, packages)
        if missing or path is None or tag["optional"].lower() in _TRUE:
            continue
        if not text or not os.path.isfile(path):  # noqa: PTH113  # Path's may raise
            close = nearest_file(path)
            yield error_at(
                tag.location,
                "missing-include",
                text,
                f"there is no file '{short(str(path))}' to include, so xacro fails, "
                "and robot_description stays empty",
                f"there is '{close}'; write that" if close else "check the path",
            )


def included_files(root: Tag, packages: PackageIndex) -> Iterator[Path]:
    """Yield the files that a xacro file includes, whatever its arguments are."""
    paths = (_included(tag, packages) for tag in root.descendants("xacro:include"))
    return (path for path in paths if path is not None)


def _included(tag: Tag, packages: PackageIndex) -> Path | None:
    """Return the file of an include; None if the file depends on arguments."""
    text, file = tag["filename"], tag.location.file
    folder = Path() if file is None else file.parent
    filled = _FIND.sub(lambda match: str(packages.get(match.group(1))), text)
    filled = filled.replace("$(dirname)", str(folder))
    if "$" in filled or _PATTERN.search(text):
        return None
    return source_path(folder / filled)  # an absolute path does not change


def parameter_findings(root: Tag, _: PackageIndex) -> Iterator[Finding]:
    """Yield unused parameters, and arguments that are declared twice."""
    # A macro can use the parameters of its caller.  Therefore, a parameter is used if
    # it occurs anywhere in the file.
    used = set(_used_words(root))
    for macro in root.descendants(_MACRO):
        for parameter in parameters_of(macro):
            name = parameter.name
            if name in used or not name:
                continue
            use = (
                f'<xacro:insert_block name="{name}"/>'
                if parameter.is_block
                else f"it, as ${{{short(name)}}}"
            )
            yield warning_at(
                macro.location,
                "unused-parameter",
                name,
                f"macro '{short(macro.written('name'))}' takes '{short(name)}', which "
                "nothing in this file uses: whatever is given for it does nothing",
                f"use {use}, or take it out of params",
            )
    first: dict[str, Tag] = {}
    for tag in root.children("xacro:arg"):
        name, default = tag["name"], tag["default"]
        earlier = first.setdefault(name, tag)
        if earlier is not tag and earlier["default"] != default:
            yield warning_at(
                tag.location,
                "duplicate-arg",
                name,
                f"the argument '{short(name)}' is declared again with the default "
                f"'{short(default)}', which does nothing: the first counts, "
                f"'{short(earlier['default'])}' at {earlier.location}",
                "remove one of the two",
            )


def _used_words(root: Tag) -> Iterator[str]:
    for tag in root.descendants():
        if tag.tag == "xacro:insert_block":
            yield tag["name"]
        if tag.tag == _MACRO:
            yield from (p.name for p in parameters_of(tag) if p.default == _OUTER)
        for text in (tag.text, *(value for _, value in tag.attributes)):
            if "$" in text:
                yield from _WORD.findall(text)


def call_findings(root: Tag, _: PackageIndex) -> Iterator[Finding]:
    """Yield calls with an empty prefix in macros that have a prefix parameter."""
    for macro in root.descendants(_MACRO):
        names = {parameter.name for parameter in parameters_of(macro)}
        prefixes = sorted(name for name in names if name.endswith("prefix"))
        for call in own_tags(macro) if prefixes else ():
            for prefix in prefixes:
                is_empty = prefix in call and call[prefix] in _EMPTY
                if is_empty and call.tag.startswith("xacro:"):
                    yield _hard_coded(macro.written("name"), call, prefix)


def _hard_coded(macro: str, call: Tag, prefix: str) -> Finding:
    return warning_at(
        call.location,
        "hardcoded-prefix",
        macro,
        f"macro '{short(macro)}' takes a {prefix}, yet hands an empty one to "
        f"<{short(call.tag)}>: what that makes never has a prefix, so a second one "
        "in the same robot collides, and so does a base_link of both",
        f'write <{short(call.tag)} {prefix}="${{{prefix}}}" …>',
    )


def interface_findings(root: Tag, _: PackageIndex) -> Iterator[Finding]:
    """Yield the misspelled interfaces that a xacro file contains as literal text."""
    for tag in root.descendants():
        kind = "default" if tag.tag in {_MACRO, "xacro:arg"} else "value"
        for name, text in _values(tag):
            if "$" in text or not _LIKE.search(text) or is_interface(text):
                continue
            meant = meant_interface(text)
            if meant:
                of = f" of '{short(name)}'" if name else ""
                yield error_at(
                    tag.location,
                    "interface-typo",
                    name or text,
                    f"the {kind} '{short(text)}'{of} is no hardware interface: "
                    "gazebo_ros_control stops at a joint that gets it, and no "
                    "controller runs",
                    f"write {meant}",
                )


def _values(tag: Tag) -> Iterator[tuple[str, str]]:
    """Yield the names that ``tag`` defines, with their values."""
    if tag.tag == "hardwareInterface":
        yield "", tag.text
    elif tag.tag == _MACRO:
        for parameter in parameters_of(tag):
            yield parameter.name, parameter.default or ""
    elif tag.tag in {"xacro:arg", "xacro:property"}:
        yield from ((tag["name"], tag[key]) for key in ("default", "value"))
    elif tag.tag.startswith("xacro:"):
        for key, value in tag.attributes:
            if key not in {"filename", "file", "name"}:
                yield key, value.strip()
