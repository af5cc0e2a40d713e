"""Functions and methods of plain values that a launch file may call.

The module contains only functions whose results are short and can be computed without
running a program.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Final

from tool0.lint.launch.evaluation import MAX_TEXT, METHODS
from tool0.lint.launch.python.values import Choice, Unknown, Value, is_text

MAX_ITEMS: Final = 10_000
"""Largest number of items in a list."""

PACKAGE_FOLDERS: Final = frozenset(
    f"ament_index_python.{middle}get_package_{what}"
    for middle in ("", "packages.")
    for what in ("share_directory", "share_path")
)
"""Functions that return the share folder of a package."""


def _join(*parts: str | PurePath) -> str:
    return os.path.join(*parts)  # noqa: PTH118  # the name it has there


def _range(*bounds: int) -> list[int]:
    numbers = range(*bounds)
    return list(numbers[:MAX_ITEMS])


FUNCTIONS: Final[Mapping[str, Callable[..., Value]]] = {
    "os.path.join": _join,
    "os.path.dirname": os.path.dirname,
    "os.path.basename": os.path.basename,
    "os.path.normpath": os.path.normpath,
    "os.path.splitext": os.path.splitext,
    "os.path.abspath": os.path.normpath,
    "os.path.realpath": os.path.normpath,
    "pathlib.Path": Path,
    "pathlib.PurePath": Path,
    "str": str,
    "int": int,
    "float": float,
    "bool": bool,
    "len": len,
    "min": min,
    "max": max,
    "abs": abs,
    "round": round,
    "range": _range,
    "list": lambda items=(): list(items),
    "tuple": lambda items=(): tuple(items),
    "sorted": sorted,
    "reversed": lambda items: list(reversed(items)),
    "enumerate": lambda items, start=0: list(enumerate(items, start)),
    "zip": lambda *items: list(zip(*items, strict=False)),
    "dict": dict,
}
_TAKES_ANYTHING: Final = ("list", "tuple", "enumerate", "zip", "dict", "reversed")
"""Functions whose arguments may contain unknown values."""

_OF_LISTS: Final = ("index", "count")
_OF_PATHS: Final = ("joinpath", "as_posix", "with_suffix", "with_name", "resolve")
_OF_PATHS_TOO: Final = ("absolute", "expanduser")
PATH_PARTS: Final = ("parent", "name", "stem", "suffix")


def call_function(
    name: str, arguments: Sequence[Value], keywords: Mapping[str, Value]
) -> Value:
    """Return the result of a library function."""
    if name not in FUNCTIONS:
        return Unknown(f"{name}() is not read")
    is_known = all(map(_is_plain, (*arguments, *keywords.values())))
    if not is_known and name not in _TAKES_ANYTHING:
        return Unknown(f"{name}() of something unknown")
    if any(isinstance(item, Unknown | Choice) for item in arguments):
        return Unknown(f"{name}() of something unknown")
    try:
        return _bounded(FUNCTIONS[name](*arguments, **keywords))
    except Exception as error:  # any exception that Python would also raise
        return Unknown(f"{name}() fails: {error}")


def call_method(
    owner: Value, name: str, arguments: Sequence[Value], keywords: Mapping[str, Value]
) -> Value:
    """Return the result of a method that does not change its object."""
    unknown = Unknown(f".{name}() is not read")
    if isinstance(owner, dict):
        return _of_dict(owner, name, arguments)
    if isinstance(owner, list) and name == "copy":
        return list(owner)
    if not all(map(_is_plain, (*arguments, *keywords.values()))):
        return unknown
    is_read = (
        (isinstance(owner, str) and name in (*METHODS, "join", "replace", "rsplit"))
        or (isinstance(owner, PurePath) and name in _OF_PATHS)
        or (isinstance(owner, list | tuple) and name in _OF_LISTS)
    )
    if isinstance(owner, PurePath) and name in (*_OF_PATHS_TOO, "resolve"):
        return owner  # the file system is not accessed
    if isinstance(owner, str) and name == "format" and len(owner) < 1000:
        is_read = all(isinstance(a, str | int | float) for a in arguments)
    if not is_read:
        return unknown
    try:
        return _bounded(getattr(owner, name)(*arguments, **keywords))
    except Exception as error:  # any exception that Python would also raise
        return Unknown(f".{name}() fails: {error}")


def _of_dict(owner: dict[Value, Value], name: str, arguments: Sequence[Value]) -> Value:
    if name in ("items", "keys", "values", "copy"):
        results: dict[str, Callable[[], Value]] = {
            "items": lambda: list(owner.items()),
            "keys": lambda: list(owner),
            "values": lambda: list(owner.values()),
            "copy": lambda: dict(owner),
        }
        return results[name]()
    if name == "get" and arguments and isinstance(arguments[0], str | int):
        return owner.get(arguments[0], arguments[1] if len(arguments) > 1 else None)
    return Unknown(f".{name}() is not read")


def change(
    owner: list[Value] | dict[Value, Value],
    name: str,
    values: tuple[Value, ...],
    is_certain: bool,
) -> bool:
    """Apply a method that changes a list or dict; return False for other methods.

    Args:
        owner: The list or dict that is changed.
        name: The name of the method.
        values: The arguments of the method.
        is_certain: Whether the method is certainly called.
    """
    if isinstance(owner, dict):
        if name != "update" or not values:
            return False
        added = values[0]
        owner.update(added if isinstance(added, dict) else {})
        return True

    def perhaps(value: Value) -> Value:
        return value if is_certain else Choice((value,))

    match name, values:
        case "append", (value,):
            owner.append(perhaps(value))
        case "extend", (list() | tuple() as items,):
            owner.extend([perhaps(item) for item in items[:MAX_ITEMS]])
            del owner[MAX_ITEMS:]
        case "extend", (value,):
            owner.append(Choice((value,)))
        case "insert", (int() as index, value):
            owner.insert(index, perhaps(value))
        case "remove", (value,) if is_certain:
            if value in owner:
                owner.remove(value)
        case (("remove" | "pop" | "clear" | "sort"), _):
            owner[:] = [Choice((item,)) for item in owner]
        case "reverse", ():
            owner.reverse()
        case _:
            return False
    return True


def _is_plain(value: Value) -> bool:
    if isinstance(value, list | tuple):
        return len(value) <= MAX_ITEMS and all(map(_is_plain, value))
    return value is None or is_text(value) or isinstance(value, bool | int | float)


def _bounded(value: Value) -> Value:
    if isinstance(value, str) and len(value) > MAX_TEXT:
        return Unknown(f"a text of more than {MAX_TEXT} characters")
    if isinstance(value, list | tuple | dict) and len(value) > MAX_ITEMS:
        return Unknown(f"more than {MAX_ITEMS} items")
    return value
