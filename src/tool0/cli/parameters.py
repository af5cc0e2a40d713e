"""Options from the parameters of a command's function: names, types and help texts.

A parameter whose type is a dataclass is a group of options: each field of the dataclass
is an option.  The help texts come from docstrings: the ``Args`` of a function, and the
string below each field.
"""

from __future__ import annotations

import ast
import inspect
import itertools
import json
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, is_dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from types import UnionType
from typing import (
    Annotated,
    Any,
    Final,
    Literal,
    Union,
    final,
    get_args,
    get_origin,
    get_type_hints,
)

from tool0.description.units import ANGLE, LENGTH, Quantity, read_number
from tool0.errors import ConfigError

_SECTION: Final = re.compile(r"^(Args|Returns|Raises):\n", re.MULTILINE)
_WORDS: Final = re.compile(r"[A-Za-z_]\w*(,[A-Za-z_]\w*)+")
"""Pattern of a list of names, such as scene,wrist."""
_ENTRY: Final = re.compile(r"^    (\w+): (.*(?:\n(?:     .*)?)*)", re.MULTILINE)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """Annotation of a parameter whose notation is not clear from its name and type."""

    name: str | None = None
    """Name of the option, if it differs from the parameter's name."""
    metavar: str | None = None
    """The placeholder of the value or values in the help."""
    is_positional: bool = False


AsJson = Annotated[bool, Option(name="json")]
"""The flag ``--json`` of a command that prints data, whose types are in ``outputs``."""


@final
@dataclass(frozen=True, slots=True)
class Reader:
    """Notation of the values of one type."""

    n_words: int | Literal["*"]
    metavar: str
    """Placeholder of the words in the help; if it is empty, the option's name is
    used."""
    read: Callable[[list[str]], object]
    choices: tuple[str, ...] = ()
    """The valid words, if there are only a few."""


Readers = Mapping[object, Reader | None]
"""Type → the notation of options of this type; None if the type cannot be an option."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """An option or a positional argument of a command."""

    owner: Callable[..., Any]
    """The function or option group that has the parameter."""
    path: tuple[str, ...]
    """Names of the enclosing groups, followed by the parameter's name."""
    option: Option
    reader: Reader | None
    """Notation of the value; None for a flag."""
    default: object

    @property
    def flag(self) -> str:
        return f"--{(self.option.name or self.path[-1]).replace('_', '-')}"

    @property
    def is_field(self) -> bool:
        return is_dataclass(self.owner)

    @property
    def is_required(self) -> bool:
        return self.default is inspect.Parameter.empty

    @property
    def metavar(self) -> str:
        """The placeholder of the value or values in the help."""
        if self.reader is None:
            return ""
        name = self.path[-1].rpartition("_")[2].upper()
        return self.option.metavar or self.reader.metavar or name

    @property
    def flags(self) -> tuple[str, ...]:
        """Spellings of the option, such as ``--realtime`` and ``--no-realtime``."""
        can_be_off = self.reader is None and self.default is True
        return (self.flag, f"--no-{self.flag[2:]}") if can_be_off else (self.flag,)

    @property
    def usage(self) -> str:
        """Text for the usage line, in brackets unless the parameter is required."""
        text = self.metavar
        if not self.option.is_positional:
            text = f"{self.flag} {text}"
        return text if self.is_required else f"[{text}]"

    @property
    def text(self) -> str:
        """Explanation of the parameter."""
        return _texts_of(self.owner).get(self.path[-1], "")

    @property
    def written_default(self) -> str:
        """Default in command-line notation; empty if it is obvious or missing."""
        return self.flag if self.default is True else _written(self.default)

    @property
    def help(self) -> str:
        """Explanation of the parameter, with its default unless that is obvious."""
        default = self.written_default
        return f"{self.text} (default: {default})" if default else self.text

    @property
    def heading(self) -> str:
        """Heading above the parameter in the help."""
        if self.option.is_positional:
            return "Arguments"
        return summary_of(self.owner).rstrip(".") if self.is_field else "Options"


def parameters_of(
    form: Callable[..., Any], readers: Readers, path: tuple[str, ...] = ()
) -> Iterator[Parameter]:
    """Yield the parameters of a function, with the fields of groups as parameters."""
    hints = get_type_hints(form, include_extras=True)
    for name, parameter in inspect.signature(form).parameters.items():
        kind, _ = _unwrapped(hints[name])
        if is_dataclass(kind) and isinstance(kind, type):
            yield from parameters_of(kind, readers, (*path, name))
        elif readers.get(kind, True) is not None:
            yield Parameter(
                owner=form,
                path=(*path, name),
                option=_option(hints[name]),
                reader=None if kind is bool else reader_of(hints[name], readers),
                default=parameter.default,
            )


# ---- types ---------------------------------------------------------------------------


def _unwrapped(kind: Any) -> tuple[Any, tuple[Any, ...]]:
    """Return a type without ``Annotated``, and its annotations."""
    if get_origin(kind) is Annotated:
        return kind.__origin__, kind.__metadata__
    return kind, ()


def _option(annotated: Any) -> Option:
    """Return the annotation of a type; for a union, that of one of its types."""
    kind, marks = _unwrapped(annotated)
    inner = get_args(kind) if get_origin(kind) in (Union, UnionType) else ()
    found = [mark for mark in marks if isinstance(mark, Option)]
    return (*found, *(_option(part) for part in inner), Option())[0]


def reader_of(annotated: Any, readers: Readers) -> Reader:
    """Return the reader for values of a type."""
    kind, marks = _unwrapped(annotated)
    reader = readers.get(kind)
    if reader is not None:
        return reader
    for mark in marks:
        if isinstance(mark, Quantity):
            return _measured(mark)
    if kind in _PLAIN:
        return _PLAIN[kind]
    items = get_args(kind)
    if get_origin(kind) is Literal:
        return _choice(items)
    if get_origin(kind) is not tuple:  # the type is a union with None
        (inner,) = (item for item in items if item is not type(None))
        return reader_of(inner, readers)
    if items[-1] is ...:
        only = reader_of(items[0], readers)
        return Reader("*", "", lambda words: tuple(only.read([w]) for w in words))
    parts = [reader_of(item, readers) for item in items]
    return Reader(
        len(parts),
        " ".join(part.metavar for part in parts),
        lambda w: tuple(p.read([t]) for p, t in zip(parts, w, strict=True)),
    )


def _measured(quantity: Quantity) -> Reader:
    metavar = quantity.name.upper()
    return Reader(1, metavar, lambda words: read_number(words[0], quantity)[0])


def _number(kind: type[float], name: str) -> Reader:
    def read(words: list[str]) -> float:
        try:
            return kind(words[0])
        except ValueError:
            raise ConfigError(f"'{words[0]}' is no {name}") from None

    return Reader(1, "NUMBER", read)


def read_path(text: str) -> Path:
    """Return the path, or raise ConfigError if ``text`` is empty."""
    if not text.strip():
        raise ConfigError("the name of the file is empty; give a file")
    return Path(text)


_PLAIN: Final[dict[object, Reader]] = {
    str: Reader(1, "", lambda words: words[0]),
    Path: Reader(1, "FILE", lambda words: read_path(words[0])),
    float: _number(float, "number"),
    int: _number(int, "whole number"),
}


def _choice(values: tuple[str, ...]) -> Reader:
    def read(words: list[str]) -> str:
        if words[0] not in values:
            raise ConfigError(f"no choice '{words[0]}'; choose {' or '.join(values)}")
        return words[0]

    return Reader(1, "|".join(values), read, choices=values)


def _written(default: object) -> str:
    """Return a default in command-line notation; an empty string if there is none."""
    if isinstance(default, bool | type | Enum) or default is None:
        return ""
    if isinstance(default, tuple):
        return " ".join(map(_written, default))
    return f"{default:g}" if isinstance(default, float) else str(default)


# ---- values of several words ---------------------------------------------------------


def joint_values(words: Sequence[str]) -> tuple[dict[str, float], dict[str, Quantity]]:
    """Return the positions in ``joint=value …`` [rad | m], and each unit's quantity."""
    values, units = {}, {}
    for name, text in assignments(words, "=").items():
        try:
            values[name], quantity = read_number(text, ANGLE, LENGTH)
        except ConfigError as error:
            raise ConfigError(f"{name}={error}") from None
        if quantity is not None:
            units[name] = quantity
    return values, units


def assignments(words: Sequence[str], sign: str) -> dict[str, str]:
    """Return ``name<sign>value …`` as a mapping; raise ConfigError for other text."""
    found: dict[str, str] = {}
    for word in words:
        name, given, value = word.partition(sign)
        if not (given and name):
            raise ConfigError(f"'{word}': write name{sign}value")
        if name in found:
            raise ConfigError(f"'{name}' is given twice")
        found[name] = value
    return found


def keywords(words: Sequence[str]) -> dict[str, object]:
    """Return ``NAME=VALUE …`` as keywords: JSON, lists (``96,96``) or text."""
    return {name: _value(text) for name, text in assignments(words, "=").items()}


def _value(text: str) -> object:
    """Return the value of JSON, a list for ``96,96`` or ``a,b``, or ``text`` itself."""
    for form in (text, f"[{text}]") if "," in text else (text,):
        try:
            value: object = json.loads(form)
        except ValueError:
            continue
        return value
    return text.split(",") if _WORDS.fullmatch(text) else text


# ---- texts ---------------------------------------------------------------------------


def description_of(form: Callable[..., Any]) -> str:
    """Return the part of the docstring above its sections."""
    return _plain(_SECTION.split(inspect.getdoc(form) or "")[0])


def summary_of(form: Callable[..., Any]) -> str:
    """Return the first line of the docstring."""
    return description_of(form).partition("\n")[0]


@cache
def _texts_of(form: Callable[..., Any]) -> dict[str, str]:
    """Return the help text of each parameter; the first call takes milliseconds."""
    return _field_texts(form) if is_dataclass(form) else _argument_texts(form)


def _argument_texts(function: Callable[..., Any]) -> dict[str, str]:
    parts = _SECTION.split(inspect.getdoc(function) or "")
    arguments = dict(zip(parts[1::2], parts[2::2], strict=True)).get("Args", "")
    return {name: _plain(text) for name, text in _ENTRY.findall(arguments)}


def _field_texts(kind: Any) -> dict[str, str]:
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    assert isinstance(definition, ast.ClassDef)
    return {
        field.target.id: _plain(below.value.value)
        for field, below in itertools.pairwise(definition.body)
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)
        if isinstance(below.value.value, str)
    }


def _plain(text: str) -> str:
    return inspect.cleandoc(text).replace("``", "`").strip()
