"""The values of URScript and its operators.

Values are immutable: an assignment to an element creates a new list. Arguments and
assigned values therefore behave as copies, as on a real robot. A string is a sequence
of bytes. Each byte is stored as one character.
"""

from __future__ import annotations

import asyncio
import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, Union, final

from tool0.ur.urscript.remote import RemoteServer
from tool0.ur.urscript.syntax import INT_RANGE, MAX_TEXT
from tool0.ur.urscript_errors import ValueProblem

MAX_LIST: Final = 10_000
"""Maximum number of elements of a list. A pose has six elements."""
MAX_WRITTEN: Final = 500
"""Maximum number of elements of a list that is converted to text."""
MAX_PRODUCT: Final = 2_000
"""Maximum number of multiplications in a matrix product."""


@final
class Pose(tuple[float, ...]):
    """``p[x, y, z, rx, ry, rz]`` [m, rad]; also used for wrenches and twists."""

    __slots__ = ()


@final
class Member(str):
    """The name of a struct's member, used as an index."""

    __slots__ = ()


@final
@dataclass(frozen=True, slots=True)
class Struct:
    """A struct of named values."""

    names: tuple[str, ...]
    values: tuple[Value, ...]


@final
class Handle:
    """A handle of a thread that was started."""

    def __init__(self, name: str, task: asyncio.Task[Value]) -> None:
        self.name = name
        self._task = task

    async def kill(self) -> None:
        """End the thread and return when it no longer moves the robot."""
        self._task.cancel()
        if self._task is asyncio.current_task():
            await asyncio.sleep(0)  # the thread ends itself
        await asyncio.wait([self._task])

    async def end(self) -> Value:
        """Wait for the thread's end and return its result; None if it was killed."""
        await asyncio.wait([self._task])
        return None if self._task.cancelled() else self._task.result()


Value: TypeAlias = Union[
    bool,
    int,
    float,
    str,
    Pose,
    "tuple[Value, ...]",
    Struct,
    Handle,
    RemoteServer,
    None,
]
_FAMILIES: Final[dict[type, str]] = {
    bool: "a boolean",
    int: "an integer",
    float: "a float",
    str: "a string",
    Pose: "a pose",
    tuple: "a list",
    Struct: "a struct",
    Handle: "a thread",
    RemoteServer: "a remote server",
    type(None): "nothing",
}


def described(value: Value) -> str:
    """Return text that describes the type of a value, with an article."""
    return _FAMILIES[type(value)]


def is_number(value: Value) -> bool:
    """Return whether a value is an integer or a float; a boolean is not a number."""
    return type(value) is float or type(value) is int


def checked_list(items: Sequence[Value]) -> tuple[Value, ...]:
    """Return a list, or a matrix as a list of equal rows.

    Raises:
        ValueProblem: If the elements have different types or are nested too deeply.
    """
    if weight(items) > MAX_LIST:
        raise ValueProblem(f"lists have at most {MAX_LIST} elements")
    families = {"a number" if is_number(item) else described(item) for item in items}
    if len(families) > 1:
        mixed = " and ".join(sorted(families))
        raise ValueProblem(f"a list has elements of one kind, not {mixed}")
    if families & {"nothing", "a thread", "a remote server"}:
        raise ValueProblem(f"{families.pop()} cannot be an element of a list")
    rows = [item for item in items if type(item) is tuple]
    if rows:
        if len({len(row) for row in rows}) > 1:
            raise ValueProblem("the rows of a matrix have equal lengths")
        if any(type(item) in {tuple, Pose} for row in rows for item in row):
            raise ValueProblem("lists can be nested once, as a matrix")
    return tuple(items)


def checked_struct(names: tuple[str, ...], values: Sequence[Value]) -> Struct:
    """Return a struct after checking the types and the number of its values."""
    if any(item is None or isinstance(item, Handle | RemoteServer) for item in values):
        raise ValueProblem("a member of a struct has a value that can be copied")
    if sum(map(_weight, values)) > MAX_LIST:
        raise ValueProblem(f"structs have at most {MAX_LIST} values")
    return Struct(names, tuple(values))


def weight(items: Sequence[Value]) -> int:
    """Return the number of values in a list, including the values of its elements."""
    if items and isinstance(items[0], Struct):  # lengths may differ
        return sum(map(_weight, items))
    return len(items) * _weight(items[0]) if items else 0


def _weight(value: Value) -> int:
    if isinstance(value, Struct):
        return sum(map(_weight, value.values))
    return weight(value) if isinstance(value, tuple) else 1


def checked_pose(items: Sequence[Value]) -> Pose:
    """Return a pose of six numbers."""
    if len(items) != 6:
        raise ValueProblem(f"a pose has 6 numbers, not {len(items)}")
    numbers: list[float] = []
    for item in items:
        if type(item) is not float and type(item) is not int:
            raise ValueProblem(f"a pose has 6 numbers, not {described(item)}")
        numbers.append(float(item))
    return Pose(numbers)


def checked_text(text: str) -> str:
    """Check the length of a string and return the string."""
    if len(text) > MAX_TEXT:
        raise ValueProblem(f"strings have at most {MAX_TEXT} bytes, not {len(text)}")
    return text


def to_text(value: Value) -> str:
    """Convert a value to text; floats have 6 decimals without trailing zeros."""
    match value:
        case bool() | int():
            return str(value)
        case float():
            if not math.isfinite(value):
                return str(value)
            text = f"{value:.6f}".rstrip("0").rstrip(".")
            return "0" if text == "-0" else text
        case str():
            return value
        case tuple():
            if weight(value) > MAX_WRITTEN:
                size = f"{MAX_WRITTEN} elements"
                raise ValueProblem(f"a list of more than {size} is no text")
            start = "p[" if isinstance(value, Pose) else "["
            return start + ", ".join(to_text(item) for item in value) + "]"
        case Struct(names, values):
            pairs = zip(names, map(to_text, values), strict=True)
            return f"struct({', '.join(f'{name} = {text}' for name, text in pairs)})"
        case _:
            raise ValueProblem(f"{described(value)} cannot be written as text")


# ---- elements -----------------------------------------------------------------------


def element(value: Value, index: Value) -> Value:
    """Return an element of a list or pose, a row of a matrix, or a struct's member."""
    k = _checked_index(value, index)
    return _items(value)[k]


def with_element(value: Value, indexes: Sequence[Value], new: Value) -> Value:
    """Return a copy of a list, matrix, pose or struct with one element replaced."""
    k = _checked_index(value, indexes[0])
    items = list(_items(value))
    rest = indexes[1:]
    changed = with_element(items[k], rest, new) if rest else new
    if isinstance(value, Struct) and not _is_alike(items[k], changed):
        raise ValueProblem(
            f"the member '{value.names[k]}' is {described(items[k])}, and cannot "
            f"become {described(changed)}"
        )
    items[k] = changed
    if isinstance(value, Struct):
        return checked_struct(value.names, items)
    return checked_pose(items) if isinstance(value, Pose) else checked_list(items)


def _is_alike(a: Value, b: Value) -> bool:
    return type(a) is type(b) or (is_number(a) and is_number(b))


def _items(value: Value) -> tuple[Value, ...]:
    if isinstance(value, Struct):
        return value.values
    if not isinstance(value, tuple):
        raise ValueProblem(f"{described(value)} has no elements")
    return value


def _checked_index(value: Value, index: Value) -> int:
    if isinstance(index, Member):
        if not isinstance(value, Struct):
            raise ValueProblem(f"{described(value)} has no member '{index}'")
        if index not in value.names:
            raise ValueProblem(
                f"the struct has no member '{index}'; it has {', '.join(value.names)}"
            )
        return value.names.index(index)
    if type(index) is not int:
        raise ValueProblem(f"an index is an integer, not {described(index)}")
    size = len(_items(value))
    if not 0 <= index < size:
        raise ValueProblem(f"index {index} of {described(value)} of {size} elements")
    return index


# ---- operators ----------------------------------------------------------------------

Operator: TypeAlias = Callable[[Value, Value], Value]
Numbers: TypeAlias = Callable[[float, float], float]


def _quotient(a: float, b: float) -> float:
    if b == 0:
        raise ValueProblem("division by zero")
    return a / b


def _remainder(a: float, b: float) -> float:
    """Return the remainder with the sign of ``a``, as in C."""
    if b == 0:
        raise ValueProblem("division by zero")
    if type(a) is int and type(b) is int:
        rest = abs(a) % abs(b)
        return rest if a >= 0 else -rest
    if not math.isfinite(a):
        raise ValueProblem(f"remainder of {a}")
    return math.fmod(a, b)


def _arithmetic(symbol: str, compute: Numbers) -> Operator:
    def apply(a: Value, b: Value) -> Value:
        kinds = type(a), type(b)
        if kinds == (float, float):
            return compute(a, b)  # type: ignore[arg-type]
        if is_number(a) and is_number(b):
            return checked_integer(compute(a, b))  # type: ignore[arg-type]
        if symbol == "+" and kinds == (str, str):
            return checked_text(f"{a}{b}")
        if Pose in kinds:
            raise ValueProblem(
                f"'{symbol}' does not apply to poses; use pose_add, pose_sub or "
                "pose_trans"
            )
        if symbol == "*" and _is_matrix(a) and (_is_matrix(b) or type(b) is tuple):
            return _matrix_product(a, b)  # type: ignore[arg-type]
        if tuple in kinds:
            return _by_element(symbol, apply, a, b)
        raise ValueProblem(
            f"'{symbol}' does not apply to {described(a)} and {described(b)}"
        )

    return apply


def checked_integer(value: float) -> float:
    """Return a number; if it is an integer, check that it has at most 32 bits."""
    if type(value) is int and value not in INT_RANGE:
        raise ValueProblem(f"the integer {value} has more than 32 bits; use floats")
    return value


def _is_matrix(value: Value) -> bool:
    return type(value) is tuple and bool(value) and type(value[0]) is tuple


def _matrix_product(a: tuple[Value, ...], b: tuple[Value, ...]) -> Value:
    columns = list(zip(*b, strict=True)) if _is_matrix(b) else [b]
    multiply, add = ARITHMETIC["*"], ARITHMETIC["+"]

    def dot(row: Value, column: Sequence[Value]) -> Value:
        items = _items(row)
        if len(items) != len(column):
            raise ValueProblem(
                f"a matrix with {len(items)} columns times one with {len(column)} rows"
            )
        total: Value = 0
        for x, y in zip(items, column, strict=True):
            total = add(total, multiply(x, y))
        return total

    if len(a) * len(columns) * len(b) > MAX_PRODUCT:
        raise ValueProblem("these matrices are too large to be multiplied")
    rows = [tuple(dot(row, column) for column in columns) for row in a]
    return tuple(rows) if _is_matrix(b) else tuple(row[0] for row in rows)


def _by_element(symbol: str, apply: Operator, a: Value, b: Value) -> Value:
    if type(a) is tuple and type(b) is tuple:
        if len(a) != len(b):
            raise ValueProblem(
                f"'{symbol}' of lists with {len(a)} and {len(b)} elements"
            )
        return tuple(apply(x, y) for x, y in zip(a, b, strict=True))
    if type(a) is tuple:
        return tuple(apply(x, b) for x in a)
    return tuple(apply(a, y) for y in _items(b))


def _ordering(symbol: str, compare: Callable[[float, float], bool]) -> Operator:
    def apply(a: Value, b: Value) -> Value:
        if not (is_number(a) and is_number(b)):
            raise ValueProblem(
                f"'{symbol}' does not apply to {described(a)} and {described(b)}"
            )
        return compare(a, b)  # type: ignore[arg-type]

    return apply


def _equality(symbol: str, compare: Callable[[Value, Value], bool]) -> Operator:
    def apply(a: Value, b: Value) -> Value:
        if type(a) is not type(b) and not (is_number(a) and is_number(b)):
            raise ValueProblem(
                f"'{symbol}' does not apply to {described(a)} and {described(b)}"
            )
        return compare(a, b)

    return apply


ARITHMETIC: Final[dict[str, Operator]] = {
    "+": _arithmetic("+", operator.add),
    "-": _arithmetic("-", operator.sub),
    "*": _arithmetic("*", operator.mul),
    "/": _arithmetic("/", _quotient),
    "%": _arithmetic("%", _remainder),
    "<": _ordering("<", operator.lt),
    ">": _ordering(">", operator.gt),
    "<=": _ordering("<=", operator.le),
    ">=": _ordering(">=", operator.ge),
    "==": _equality("==", operator.eq),
    "!=": _equality("!=", operator.ne),
}
"""Operators that evaluate both operands."""


def negated(value: Value) -> Value:
    """Return ``-value``."""
    return ARITHMETIC["-"](0, value) if type(value) is not float else -value


def positive(value: Value) -> Value:
    """Return ``+value``."""
    return ARITHMETIC["+"](0, value)


def truth(value: Value) -> bool:
    """Return whether a condition is True, a nonzero number or a nonempty string."""
    if type(value) in {bool, int, float, str}:
        return bool(value)
    raise ValueProblem(f"a condition is a boolean, not {described(value)}")


def boolean(symbol: str, value: Value) -> bool:
    """Check that an operand of ``and``, ``or``, ``xor`` or ``not`` is a boolean."""
    if type(value) is not bool:
        raise ValueProblem(f"'{symbol}' applies to booleans, not to {described(value)}")
    return value
