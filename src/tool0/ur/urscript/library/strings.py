"""Functions for strings of bytes; indexes start at 0."""

from __future__ import annotations

import re
from typing import Final

from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import AnyValue, Integer, Text
from tool0.ur.urscript.values import Value, checked_integer, checked_text, to_text
from tool0.ur.urscript_errors import ValueProblem

_INTEGER: Final = re.compile(r"[+-]?[0-9]{1,11}")
_FLOAT: Final = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


def str_at(src: Text, index: Integer) -> str:
    """Return one byte of a string as a string."""
    if not 0 <= index < len(src):
        raise ValueProblem(f"index {index} of a string of {len(src)} bytes")
    return src[index]


def str_cat(op1: AnyValue, op2: AnyValue) -> str:
    """Convert two values to strings and return the concatenated string."""
    return checked_text(to_text(op1) + to_text(op2))


def str_empty(str_: Text) -> bool:
    """Return whether a string is empty."""
    return not str_


def str_find(src: Text, target: Text, start_from: Integer = 0) -> int:
    """Return the index of a string in another string, or -1 if it is not found."""
    if start_from < 0:
        raise ValueProblem(f"start_from is {start_from}, less than 0")
    return src.find(target, start_from)


def str_len(str_: Text) -> int:
    """Return the number of bytes of a string."""
    return len(str_)


def str_sub(src: Text, index: Integer, len_: Integer | None = None) -> str:
    """Return at most len bytes starting at an index; by default, all bytes."""
    if not 0 <= index <= len(src):
        raise ValueProblem(f"index {index} of a string of {len(src)} bytes")
    if len_ is None:
        return src[index:]
    if len_ < 0:
        raise ValueProblem(f"len is {len_}, less than 0")
    return src[index : index + len_]


def to_num(str_: Text) -> Value:
    """Return the number in a string as an integer or a float."""
    text = str_.strip()
    if _INTEGER.fullmatch(text):
        return checked_integer(int(text))
    if _FLOAT.fullmatch(text):
        return float(text)
    raise ValueProblem(f"'{str_}' is not a number")


def to_str(val: AnyValue) -> str:
    """Convert a value to a string."""
    return checked_text(to_text(val))


FUNCTIONS: Final[tuple[Function, ...]] = tuple(
    function(item)
    for item in (
        *(str_at, str_cat, str_empty, str_find, str_len, str_sub, to_num, to_str),
    )
)
