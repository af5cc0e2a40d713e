"""Conversion of numbers with units in a program's YAML to numbers in SI units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from types import UnionType
from typing import (
    Annotated,
    Any,
    NamedTuple,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import msgspec

from tool0.description.units import Quantity
from tool0.description.yaml_tree import YamlEntry
from tool0.description.yaml_values import number_of


class _Kind(NamedTuple):
    """One of the types that a value is allowed to have."""

    type: Any
    quantity: Quantity | None


def plain_in_si(entry: YamlEntry, annotated: Any) -> object:
    """Return an entry as dicts, lists and scalars, with numbers converted to SI.

    A value that does not match the type is returned unchanged; ``msgspec`` then refuses
    the value.

    Raises:
        ConfigError: If a number has a wrong unit; the error contains the location.
    """
    kinds = tuple(_kinds(annotated))
    if entry.is_mapping:
        types = _types_of_values(entry, kinds)
        return {
            name: plain_in_si(child, types.get(name, Any))
            for name, child in entry.children.items()
        }
    if entry.is_list:
        items = next((get_args(kind.type) for kind in kinds if _is_list(kind)), ())
        of_all = items[0] if items[1:] == (...,) else Any
        types_of_items = dict(enumerate(items)) if of_all is Any else {}
        return [
            plain_in_si(item, types_of_items.get(number, of_all))
            for number, item in enumerate(entry.items)
        ]
    value = entry.scalar
    for kind in kinds:
        if kind.quantity and isinstance(value, str) and any(map(str.isdigit, value)):
            return number_of(entry, kind.quantity)
    return value


def _kinds(annotated: Any) -> Iterator[_Kind]:
    """Yield the types of a union, or the type itself if it is not a union."""
    marks: tuple[Any, ...] = ()
    if get_origin(annotated) is Annotated:
        marks, annotated = annotated.__metadata__, annotated.__origin__
    if get_origin(annotated) in (Union, UnionType):
        for part in get_args(annotated):
            yield from _kinds(part)
        return
    quantities = (mark for mark in marks if isinstance(mark, Quantity))
    yield _Kind(annotated, next(quantities, None))


def _is_list(kind: _Kind) -> bool:
    return get_origin(kind.type) is tuple


def _types_of_values(entry: YamlEntry, kinds: tuple[_Kind, ...]) -> Mapping[str, Any]:
    """Return the types of a mapping's values, for the keys with known types."""
    for kind in kinds:
        if get_origin(kind.type) is dict:
            return dict.fromkeys(entry.children, get_args(kind.type)[1])
        if isinstance(kind.type, type) and issubclass(kind.type, msgspec.Struct):
            config = kind.type.__struct_config__
            tag = entry.children.get(config.tag_field or "")
            if config.tag is None or (tag is not None and tag.scalar == config.tag):
                return _fields(kind.type)
    return {}


@cache
def _fields(kind: type[msgspec.Struct]) -> Mapping[str, Any]:
    return get_type_hints(kind, include_extras=True)
