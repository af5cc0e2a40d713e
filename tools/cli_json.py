"""Tables of the JSON objects that commands print, for docs/reference/cli.md.

The keys come from the types in ``tool0.cli.outputs``, and their meanings from the texts
below the fields of these types.
"""

from __future__ import annotations

import collections.abc
import dataclasses
import enum
import functools
import operator
import re
import types
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal, NamedTuple, get_args, get_origin

from msgspec import Struct
from tools.request_docs import field_docs

from tool0.cli.outputs import FieldsOf, Output

_WORDS: Final[Mapping[object, str]] = {
    float: "number",
    int: "integer",
    str: "text",
    bool: "Boolean",
    Path: "text",
    type(None): "null",
}
_LISTS: Final = (tuple, list, collections.abc.Sequence)
_MAPPINGS: Final = (dict, collections.abc.Mapping)
_PYTHON: Final = re.compile(r"`?None`?")


class Key(NamedTuple):
    """A key of an object."""

    kind: Any
    """Type of the value."""
    text: str
    """Meaning of the value."""
    is_required: bool


def described(outputs: tuple[Output, ...]) -> str:
    """Return the text of the objects that one command prints."""
    parts = []
    for output in outputs:
        condition = f"{output.when}, the" if output.when else "The"
        parts.append(f"{condition} output of `--json` has these keys:\n")
        parts += ["| key | type | meaning |", "| --- | --- | --- |"]
        parts += [
            f"| `{path}` | {kind} | {text} |"
            for path, kind, text in _rows(output.shape)
        ]
        parts.append("")
    return "\n".join(parts)


def _rows(
    kind: Any, above: str = "", seen: tuple[Any, ...] = ()
) -> Iterator[tuple[str, str, str]]:
    """Yield the path, the type and the meaning of each key, also of inner objects."""
    objects = [option for option in options(kind) if has_keys(option)]
    shown: set[str] = set()
    for option in objects:
        for name, key in keys_of(option).items():
            path = above + name
            if option in seen or path in shown:
                continue
            shown.add(path)
            is_everywhere = all(name in keys_of(other) for other in objects)
            only = "" if is_everywhere else " Not in all elements."
            yield path, _type(key.kind), key.text + only
            yield from _rows(key.kind, f"{path}.", (*seen, option))
    for option in options(kind):
        if (element := element_of(option)) is not None:
            yield from _rows(element, f"{above.removesuffix('.')}[].", seen)
        elif (entry := entry_of(option)) is not None:
            label, value = entry
            if not above:
                yield label, _type(value), f"One entry per {label.lower()}."
            yield from _rows(value, f"{above}{label}.", seen)


def _type(kind: Any) -> str:
    """Return the type of a JSON value in words."""
    return " or ".join(dict.fromkeys(map(_single, options(kind))))


def _single(option: Any) -> str:
    if has_keys(option) or option is Any:
        return "object" if has_keys(option) else "any value"
    if (element := element_of(option)) is not None:
        many = {"text": "texts", "Boolean": "Booleans", "null": "nulls"}
        word = _type(element)
        return f"list of {many.get(word, f'{word}s')}"
    if (entry := entry_of(option)) is not None:
        label, value = entry
        return "object" if value is Any else f"object: {label} → {_type(value)}"
    if get_origin(option) is Literal:
        return " or ".join(f"`{value}`" for value in get_args(option))
    if isinstance(option, type) and issubclass(option, enum.Enum):
        return _WORDS[type(next(iter(option)).value)]
    return _WORDS[option]


# ---- types ---------------------------------------------------------------------------


def options(kind: Any) -> tuple[Any, ...]:
    """Return the alternatives of a union, or the type itself."""
    if get_origin(kind) in (typing.Union, types.UnionType):
        return tuple(one for item in get_args(kind) for one in options(item))
    return (kind,)


def has_keys(kind: Any) -> bool:
    """Return whether the values of a type are objects with known keys."""
    if get_origin(kind) is Annotated:
        return any(isinstance(mark, FieldsOf) for mark in get_args(kind)[1:])
    return isinstance(kind, type) and (
        dataclasses.is_dataclass(kind)
        or issubclass(kind, Struct)
        or typing.is_typeddict(kind)
    )


@functools.cache
def keys_of(kind: Any) -> Mapping[str, Key]:
    """Return the keys of an object; ``has_keys`` must be True."""
    sources = [kind]
    if get_origin(kind) is Annotated:
        marks = (mark for mark in get_args(kind)[1:] if isinstance(mark, FieldsOf))
        sources = [source for mark in marks for source in mark.types]
    found: dict[str, Key] = {}
    for source in sources:
        texts = field_docs(source)
        required = getattr(source, "__required_keys__", None)
        for name, hint in typing.get_type_hints(source, include_extras=True).items():
            if get_origin(hint) is typing.ClassVar:
                continue
            text = _PYTHON.sub("null", texts.get(name, ""))
            found[name] = Key(hint, text, required is None or name in required)
    return found


def element_of(kind: Any) -> Any:
    """Return the type of the elements of a list; None if the type is no list."""
    if get_origin(kind) not in _LISTS:
        return None
    elements = tuple(item for item in get_args(kind) if item is not Ellipsis)
    return functools.reduce(operator.or_, elements)


def entry_of(kind: Any) -> tuple[str, Any] | None:
    """Return the label of the keys, and the type of the values, of a mapping."""
    if get_origin(kind) is Annotated and not has_keys(kind):
        kind = get_args(kind)[0]
    if get_origin(kind) not in _MAPPINGS:
        return None
    key, value = get_args(kind)
    label = get_args(key)[1] if get_origin(key) is Annotated else "NAME"
    return label, value
