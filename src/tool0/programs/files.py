"""Programs as YAML files that users can read and edit."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, get_args

import msgspec
from msgspec import NODEFAULT, Struct
from msgspec.structs import fields

from tool0.description.yaml_tree import YamlEntry, read_verbatim_text, text_of
from tool0.errors import ConfigError, SourceLocation, did_you_mean
from tool0.programs.measures import plain_in_si
from tool0.protocol.program import Program, Step, StepPath
from tool0.protocol.programs import ProgramProblem
from tool0.protocol.request import problem_text

_PLACE: Final = re.compile(r"^(?P<what>.*?)(?: - at `\$(?P<path>.*)`)?$", re.DOTALL)
_PART: Final = re.compile(r"\.(\w+)|\[(\d+)\]")
_UNKNOWN: Final = re.compile(r"unknown field `(\w+)`")
KINDS: Final = tuple(str(kind.__struct_config__.tag) for kind in get_args(Step))
"""Names of all kinds of steps."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramFile:
    """A program from a file, with the line numbers of its steps."""

    program: Program
    file: Path | None
    lines: Mapping[StepPath, int]
    """Line number of each step in the file, counted from 1."""

    def located(self, problem: ProgramProblem) -> ProgramProblem:
        """Return a copy of a problem, with the line number of the step added."""
        return msgspec.structs.replace(problem, line=self.lines.get(problem.step))


def read_program(file: Path) -> ProgramFile:
    """Return the program in a file.

    Raises:
        ConfigError: If the file cannot be read or is not a program; the message
            contains the file and the line number.
    """
    return parse_program(text_of(file), file)


def parse_program(text: str, file: Path | None = None) -> ProgramFile:
    """Return the program in YAML text; ``file`` is the origin of the text.

    Raises:
        ConfigError: If the text is not a program; the message contains the line number.
    """
    tree = read_verbatim_text(text, SourceLocation(file, 1))
    tree.require_unique_keys()
    root = tree.root
    if not root.is_mapping:
        raise ConfigError(
            "a program needs 'name' and 'steps', got "
            + ("an empty file" if root.is_null else root.describe()),
            root.location,
        )
    for entry in root.leaves():
        _require_finite(entry)
    try:
        # YAML 1.1 reads 1e-3 as a string.
        program = msgspec.convert(plain_in_si(root, Program), Program, strict=False)
    except msgspec.ValidationError as error:
        raise _explained(error, root) from None
    lines: dict[StepPath, int] = {}
    _note_lines(root, (), lines)
    return ProgramFile(program=program, file=file, lines=lines)


def program_text(program: Program) -> str:
    """Return the YAML of a program; entries with default values are omitted."""
    import yaml

    text: str = yaml.safe_dump(
        _plain(program), sort_keys=False, allow_unicode=True, default_flow_style=None
    )
    return text


def _require_finite(entry: YamlEntry) -> None:
    for item in entry.items:
        for leaf in item.leaves():
            _require_finite(leaf)
    value = entry.scalar
    if isinstance(value, float) and not math.isfinite(value):
        where = f"'{entry.key}': " if entry.key else ""
        raise ConfigError(f"{where}must be finite, got {value}", entry.location)


def _note_lines(
    entry: YamlEntry, parents: StepPath, lines: dict[StepPath, int]
) -> None:
    steps = entry.children.get("steps")
    for number, item in enumerate(steps.items if steps else (), 1):
        path = (*parents, number)
        if item.location.line is not None:
            lines[path] = item.location.line
        _note_lines(item, path, lines)


def _explained(error: msgspec.ValidationError, root: YamlEntry) -> ConfigError:
    """Return an error with the line number of the invalid entry."""
    what, path = problem_text(error), ""
    found = _PLACE.match(what)
    if found is not None:
        what, path = found["what"], found["path"] or ""
    entry = root
    for name, number in _PART.findall(path):
        if name and name in entry.children:
            entry = entry.children[name]
        elif number and int(number) < len(entry.items):
            entry = entry.items[int(number)]
        else:
            break
    if path.endswith(".kind"):
        what = f"{what}; the kinds of steps are {', '.join(KINDS)}"
    unknown = _UNKNOWN.search(what)
    if unknown is not None:
        what = f"unknown key '{unknown[1]}'{_hint(unknown[1], entry)}"
        entry = entry.children.get(unknown[1], entry)
    where = f"'{entry.key}': " if entry.key else ""
    return ConfigError(f"{where}{what}", entry.location)


def _hint(name: str, entry: YamlEntry) -> str:
    """Return a hint: the key that was probably intended in a step or the program."""
    kind = entry.children.get("kind")
    of = [item for item in get_args(Step) if kind and _tag(item) == kind.scalar]
    structs = of or [Program]
    return did_you_mean(
        name, [field.name for item in structs for field in fields(item)]
    )


def _tag(kind: type[Struct]) -> Any:
    return kind.__struct_config__.tag


def _plain(value: Any) -> Any:
    """Return the YAML form of a value."""
    if isinstance(value, Struct):
        kind, tag = type(value), _tag(type(value))
        found = {} if tag is None else {"kind": tag}
        for field in fields(kind):
            item = getattr(value, field.name)
            default = field.default
            if field.default_factory is not NODEFAULT:
                default = field.default_factory()
            if item != default or field.name == "format":
                found[field.name] = _plain(item)
        return found
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value
