"""Finds the xacro files that commands of a launch file load, and their arguments."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import Final, final

from tool0.errors import DescriptionError, SourceLocation
from tool0.lint.launch.load_context import parse_limited
from tool0.lint.launch.model import LaunchFile, Parameter, Text
from tool0.lint.launch.substitution import Substitution
from tool0.lint.packages import PackageIndex
from tool0.lint.robot.elements import Tag

MAX_FILES: Final = 200
_GIVEN = re.compile(r"""(\w+):=['"]?((?:\$\([^()]*\)|[^\s'"$])*)""")
_ARGUMENT = re.compile(r"\$\(arg\s+([^\s()]+)\s*\)")
_PROPERTY = re.compile(r"\$\{\s*(\w+)\s*\}")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class XacroCall:
    """The command ``xacro FILE name:=value …`` of a parameter."""

    file: Path | None
    args: Mapping[str, str]
    """Arguments as they are given in the command."""
    uses: Mapping[str, tuple[str, ...]]
    """Arguments of the launch file that each xacro argument uses, by xacro argument."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class XacroUse:
    """An attribute of a xacro file that contains ``$(arg …)``."""

    argument: str
    location: SourceLocation
    element: str
    attribute: str
    """Name of the attribute; empty for the text of the element."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class XacroFile:
    """A xacro file, together with all files that it includes."""

    file: Path | None
    """Path of the file; None if it is unknown."""
    written: str
    """Name of the file as it is written in the including file."""
    location: SourceLocation
    """Location of the element that includes the file."""
    reason: str = ""
    """Reason why the file could not be read; empty if it was read."""
    defaults: Mapping[str, str] = field(default_factory=dict)
    """Default values of the arguments that the file declares, by argument."""
    uses: tuple[XacroUse, ...] = ()
    includes: tuple[XacroFile, ...] = ()

    def walk(self) -> Iterator[XacroFile]:
        """Yield this file and all files that it includes."""
        yield self
        for include in self.includes:
            yield from include.walk()


def xacro_call(parameter: Parameter) -> XacroCall | None:
    """Return the xacro call in a parameter's command; None if there is none."""
    if parameter.source != "command":
        return None
    raw = parameter.content.raw
    words = list(parameter.words)
    while words and PurePath(words[0]).name not in ("xacro", "xacro.py"):
        words.pop(0)  # for example, `rosrun xacro`
    if not words and not re.search(r"\bxacro(\.py)?\b", raw):
        return None
    while len(words) > 1 and PurePath(words[1]).name in ("xacro", "xacro.py"):
        words.pop(0)
    given = dict(w.split(":=", 1) for w in words[1:] if ":=" in w)
    files = [w for w in words[1:] if ":=" not in w and not w.startswith("-")]
    uses = {
        name: tuple(dict.fromkeys(_ARGUMENT.findall(value)))
        for name, value in _GIVEN.findall(raw)
    }
    return XacroCall(file=Path(files[0]) if files else None, args=given, uses=uses)


def xacro_robots(
    launch: LaunchFile, packages: PackageIndex
) -> dict[Parameter, XacroFile]:
    """Return the xacro file of every parameter that calls xacro, by parameter."""
    found = {}
    for parameter in launch.parameters(active_only=False):
        call, content = xacro_call(parameter), parameter.content
        where = parameter.place.location
        if call is not None and call.file is not None:
            file, reader = call.file, _XacroReader(packages, call.args)
            found[parameter] = reader.read(file.absolute(), str(file), where)
        elif call is not None:
            reason = content.reason or "no file is named"
            found[parameter] = XacroFile(
                file=None, written=content.raw, location=where, reason=reason
            )
    return found


@final
class _XacroReader:
    """Reads the xacro files that one call includes."""

    def __init__(self, packages: PackageIndex, args: Mapping[str, str]) -> None:
        self._packages = packages
        self._values = {
            name: Text(raw=value, resolved=value, location=SourceLocation(None))
            for name, value in args.items()
        }
        self._properties: dict[str, str] = {}
        self._open: list[Path] = []
        self._left = MAX_FILES

    def read(self, file: Path, written: str, where: SourceLocation) -> XacroFile:
        """Return one file and the files that it includes."""
        result = XacroFile(file=file, written=written, location=where)
        self._left -= 1
        if file in self._open:
            return replace(result, reason="it includes itself")
        if self._left < 0:
            return replace(result, reason=f"it is one of more than {MAX_FILES}")
        try:
            root = parse_limited(file)
        except DescriptionError as error:
            return replace(result, reason=error.message)
        if root is None:
            return replace(result, reason="it is empty")
        self._open.append(file)
        defaults: dict[str, str] = {}
        uses: list[XacroUse] = []
        includes: list[XacroFile] = []
        for tag in Tag(root).descendants():
            self._read_tag(tag, file, defaults, includes)
            uses += _uses(tag)
        self._open.pop()
        return replace(
            result, defaults=defaults, uses=tuple(uses), includes=tuple(includes)
        )

    def _read_tag(
        self,
        tag: Tag,
        file: Path,
        defaults: dict[str, str],
        includes: list[XacroFile],
    ) -> None:
        name = tag.written("name")
        if tag.tag == "xacro:arg":
            defaults[name] = tag.written("default")
            value = self._resolve(defaults[name], file)
            self._values.setdefault(name, value)
        elif tag.tag == "xacro:property" and "value" in tag:
            text = self._resolve(tag.written("value"), file)
            if text.resolved is not None:
                self._properties.setdefault(name, text.resolved)
        elif tag.tag == "xacro:include":
            includes.append(self._include(tag, file))

    def _include(self, tag: Tag, file: Path) -> XacroFile:
        written, where = tag.written("filename"), tag.location
        text = self._resolve(written, file)
        if text.resolved is None or "$" in text.resolved:
            reason = text.reason or "it depends on an expression of xacro"
            return XacroFile(file=None, written=written, location=where, reason=reason)
        return self.read((file.parent / text.resolved).absolute(), written, where)

    def _resolve(self, raw: str, file: Path) -> Text:
        raw = _PROPERTY.sub(lambda m: self._properties.get(m[1], m[0]), raw[:10_000])
        work = Substitution(
            file=file,
            location=SourceLocation(file),
            values=self._values,
            declared=self._values,
            packages=self._packages,
            anonymous=str,
        )
        return work.resolve(raw)


def _uses(tag: Tag) -> Iterator[XacroUse]:
    for attribute, text in (*tag.attributes, ("", tag.text)):
        if "$(arg" not in text:
            continue
        for name in dict.fromkeys(_ARGUMENT.findall(text)):
            yield XacroUse(
                argument=name,
                location=tag.location,
                element=tag.tag,
                attribute=attribute,
            )
