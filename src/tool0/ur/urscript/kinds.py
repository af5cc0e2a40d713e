"""The kinds of values that library functions accept, for use in annotations.

A kind converts a value for the implementation. If a value cannot be converted, the kind
raises an error that states the accepted values.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Final, TypeAlias, cast, final

from tool0.description.transform import FARTHEST
from tool0.protocol.state import Six
from tool0.ur.urscript.syntax import INT_RANGE
from tool0.ur.urscript.values import Pose, Value, described, is_number
from tool0.ur.urscript_errors import ValueProblem


@final
@dataclass(frozen=True, slots=True)
class Kind:
    """The values that a parameter accepts."""

    words: str
    # Any, because the type depends on the annotation that uses this kind.
    convert: Callable[[Value], Any]
    """Function that converts a value; raises ValueProblem if this is impossible."""
    sizes: tuple[int, ...] = ()
    """Allowed lengths of list literals; empty if any length is allowed."""


def _wrong(words: str, value: Value) -> ValueProblem:
    got = described(value)
    if type(value) is tuple:
        got = f"a list of {len(value)}"
    return ValueProblem(f"{words} is needed, not {got}")


def _number(value: Value) -> float:
    if type(value) is not float and type(value) is not int:
        raise _wrong("a number", value)
    if not math.isfinite(value):
        raise ValueProblem(f"a finite number is needed, not {value}")
    return value


def _integer(value: Value) -> int:
    """Return an integer; as on a robot, a float without a fraction is accepted."""
    if type(value) is float and value.is_integer() and int(value) in INT_RANGE:
        return int(value)
    if type(value) is not int:
        raise _wrong("an integer", value)
    return value


def _bool(value: Value) -> bool:
    if type(value) is not bool:
        raise _wrong("a boolean", value)
    return value


def _text(value: Value) -> str:
    if type(value) is not str:
        raise _wrong("a string", value)
    return value


def _any(value: Value) -> Value:
    if value is None:
        raise _wrong("a value", value)
    return value


def _pose(value: Value) -> Pose:
    if type(value) is not Pose:
        raise _wrong("a pose p[x, y, z, rx, ry, rz]", value)
    _check(value, FARTHEST)
    return value


def _check(values: tuple[Value, ...], largest: float) -> None:
    """Raise ValueProblem if a number is too large or not finite."""
    for value in cast("tuple[float, ...]", values):
        if not math.isfinite(value):
            raise ValueProblem(f"finite numbers are needed, not {value}")
        if abs(value) > largest:
            raise ValueProblem(f"{value:g} is too large")


def _list(value: Value) -> tuple[Value, ...]:
    if type(value) is not tuple:
        raise _wrong("a list", value)
    return value


def _numbers(size: int | None, words: str) -> Callable[[Value], tuple[float, ...]]:
    def convert(value: Value) -> tuple[float, ...]:
        is_list = type(value) is tuple or (size == 6 and type(value) is Pose)
        if not is_list or not isinstance(value, tuple):
            raise _wrong(words, value)
        if size is not None and len(value) != size:
            raise _wrong(words, value)
        if not all(is_number(item) for item in value):
            raise ValueProblem(f"{words} is needed")
        _check(value, math.inf if size is None else FARTHEST)
        return tuple(float(item) for item in value)  # type: ignore[arg-type]

    return convert


def _target(value: Value) -> Value:
    if type(value) is Pose:
        return _pose(value)
    return _numbers(6, _TARGET)(value)


def _flags(value: Value) -> tuple[bool, ...]:
    words = "a list of six 0 or 1"
    if not isinstance(value, tuple) or len(value) != 6:
        raise _wrong(words, value)
    if not all(item in (0, 1) for item in value):
        raise ValueProblem(f"{words} is needed")
    return tuple(bool(item) for item in value)


_TARGET: Final = "a list of six joint positions or a pose"
_JOINTS: Final = "a list of six numbers, one for each joint,"

Number: TypeAlias = Annotated[float, Kind("a number", _number)]
Integer: TypeAlias = Annotated[int, Kind("an integer", _integer)]
Bool: TypeAlias = Annotated[bool, Kind("a boolean", _bool)]
Text: TypeAlias = Annotated[str, Kind("a string", _text)]
AnyValue: TypeAlias = Annotated[Value, Kind("a value", _any)]
PoseLike: TypeAlias = Annotated[Pose, Kind("a pose", _pose)]
ListLike: TypeAlias = Annotated[tuple[Value, ...], Kind("a list", _list)]
Joints: TypeAlias = Annotated[Six, Kind(_JOINTS, _numbers(6, _JOINTS), (6,))]
Target: TypeAlias = Annotated[Pose | Six, Kind(_TARGET, _target, (6,))]
Spatial: TypeAlias = Annotated[
    Six, Kind("six numbers", _numbers(6, "a list of six numbers or a pose"), (6,))
]
Vector: TypeAlias = Annotated[
    tuple[float, float, float],
    Kind("three numbers", _numbers(3, "a list of three numbers"), (3,)),
]
Numbers: TypeAlias = Annotated[
    tuple[float, ...], Kind("numbers", _numbers(None, "a list of numbers"))
]
Flags: TypeAlias = Annotated[
    tuple[bool, bool, bool, bool, bool, bool], Kind("six flags", _flags, (6,))
]
