"""Functions of URScript's module urmath for numbers, lists and matrices."""

from __future__ import annotations

import math
import random as python_random
from typing import Final, cast

import numpy as np

from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import AnyValue, Integer, ListLike, Number, Numbers
from tool0.ur.urscript.library.poses import pose_inv
from tool0.ur.urscript.syntax import INT_RANGE
from tool0.ur.urscript.values import (
    MAX_LIST,
    Pose,
    Value,
    checked_integer,
    checked_list,
    described,
)
from tool0.ur.urscript_errors import ValueProblem

_BITS: Final = 32
_MAX_MATRIX: Final = 100
"""Maximum number of rows of a matrix that ``inv`` accepts."""


def acos(f: Number) -> float:
    """Return the arc cosine [rad]."""
    if not -1.0 <= f <= 1.0:
        raise ValueProblem(f"{f} is outside of [-1, 1]")
    return math.acos(f)


def asin(f: Number) -> float:
    """Return the arc sine [rad]."""
    if not -1.0 <= f <= 1.0:
        raise ValueProblem(f"{f} is outside of [-1, 1]")
    return math.asin(f)


def atan(f: Number) -> float:
    """Return the arc tangent [rad]."""
    return math.atan(f)


def atan2(x: Number, y: Number) -> float:
    """Return the arc tangent of x / y in the correct quadrant [rad]."""
    return math.atan2(x, y)


def sin(f: Number) -> float:
    """Return the sine of an angle [rad]."""
    return math.sin(f)


def cos(f: Number) -> float:
    """Return the cosine of an angle [rad]."""
    return math.cos(f)


def tan(f: Number) -> float:
    """Return the tangent of an angle [rad]."""
    return math.tan(f)


def sqrt(f: Number) -> float:
    """Return the square root."""
    if f < 0.0:
        raise ValueProblem(f"{f} is negative")
    return math.sqrt(f)


def exp(f: Number) -> float:
    """Return e to the power of f."""
    try:
        return math.exp(f)
    except OverflowError:
        raise ValueProblem(f"exp({f}) is too large") from None


def log(b: Number, f: Number) -> float:
    """Return the logarithm of f to the base b."""
    if b <= 0.0 or b == 1.0 or f <= 0.0:
        raise ValueProblem(f"no logarithm of {f} to the base {b}")
    return math.log(f) / math.log(b)


def pow_(base: Number, exponent: Number) -> float:
    """Return base to the power of exponent."""
    try:
        return math.pow(base, exponent)
    except (ValueError, OverflowError):
        raise ValueProblem(f"{base} to the power of {exponent}") from None


def ceil(f: Number) -> Value:
    """Return the smallest integer that is not less than f."""
    return checked_integer(math.ceil(f))


def floor(f: Number) -> Value:
    """Return the largest integer that is not greater than f."""
    return checked_integer(math.floor(f))


def d2r(d: Number) -> float:
    """Convert an angle from degrees to radians."""
    return math.radians(d)


def r2d(r: Number) -> float:
    """Convert an angle from radians to degrees."""
    return math.degrees(r)


def random() -> float:
    """Return a random number between 0 and 1."""
    return python_random.random()


def norm(a: AnyValue) -> Value:
    """Return the absolute value of a number, or the norm of a list or pose."""
    if isinstance(a, bool | str) or not isinstance(a, int | float | tuple):
        raise ValueProblem(f"{described(a)} has no norm")
    return math.hypot(*_numbers(a)) if isinstance(a, tuple) else abs(a)


def normalize(v: Numbers) -> Value:
    """Return a list of numbers that is scaled to norm 1."""
    length = math.hypot(*v)
    if length == 0.0:
        raise ValueProblem("a list of zeros has no direction")
    return tuple(x / length for x in v)


def length(v: AnyValue) -> int:
    """Return the number of elements in a list, or the number of bytes in a string."""
    if not isinstance(v, str | tuple):
        raise ValueProblem(f"{described(v)} has no length")
    return len(v)


def get_list_length(v: ListLike) -> int:
    """Return the number of elements of a list."""
    return len(v)


def size(v: AnyValue) -> Value:
    """Return the length of a list, or the numbers of rows and columns of a matrix."""
    if isinstance(v, tuple) and v and isinstance(v[0], tuple):
        return (len(v), len(v[0]))
    return length(v)


def make_list(
    length: Integer, initial_value: AnyValue, capacity: Integer | None = None
) -> Value:
    """Return a list of equal elements; the capacity has no effect."""
    if not 0 <= length <= MAX_LIST or (capacity or 0) > MAX_LIST:  # in advance
        raise ValueProblem(f"lists have 0 to {MAX_LIST} elements")
    if isinstance(initial_value, tuple) and not isinstance(initial_value, Pose):
        raise ValueProblem("lists of lists are written as matrices")
    return checked_list((initial_value,) * length)


def integer_to_binary_list(x: Integer) -> Value:
    """Return the 32 bits of an integer, starting with the least significant bit."""
    return tuple(bool(x >> k & 1) for k in range(_BITS))


def binary_list_to_integer(l_: ListLike) -> Value:
    """Convert a list of up to 32 bits to an integer, least significant bit first."""
    bits = l_[:_BITS]
    if not all(isinstance(bit, bool) for bit in bits):
        raise ValueProblem("a list of booleans is needed")
    value = sum(1 << k for k, bit in enumerate(bits) if bit)
    return value if value in INT_RANGE else value - (1 << _BITS)


def transpose(m: ListLike) -> Value:
    """Return the transpose of a matrix."""
    if not m or not isinstance(m[0], tuple):
        raise ValueProblem("a matrix is needed")
    return tuple(zip(*cast("tuple[tuple[Value, ...], ...]", m), strict=True))


def inv(m: AnyValue) -> Value:
    """Return the inverse of a square matrix or of a pose."""
    if isinstance(m, Pose):
        return pose_inv(m)
    if not isinstance(m, tuple) or not m or not isinstance(m[0], tuple):
        raise ValueProblem("a matrix or a pose is needed")
    rows = [_numbers(row) for row in m if isinstance(row, tuple)]
    if len(rows) != len(rows[0]) or len(rows) > _MAX_MATRIX:
        raise ValueProblem(f"a square matrix of at most {_MAX_MATRIX} rows is needed")
    try:
        inverse = np.linalg.inv(np.asarray(rows))
    except np.linalg.LinAlgError:
        raise ValueProblem("the matrix is singular") from None
    return tuple(tuple(row) for row in inverse.tolist())


def _numbers(values: tuple[Value, ...]) -> list[float]:
    numbers = [x for x in values if isinstance(x, int | float) and x is not True]
    if len(numbers) != len(values):
        raise ValueProblem("a list of numbers is needed")
    return [float(x) for x in numbers]


FUNCTIONS: Final[tuple[Function, ...]] = (
    *(function(item) for item in (acos, asin, atan, atan2, ceil, cos, d2r, exp)),
    *(function(item) for item in (floor, get_list_length, inv, length, log)),
    *(function(item) for item in (make_list, norm, normalize, r2d, random, sin)),
    *(function(item) for item in (size, sqrt, tan, transpose)),
    function(pow_, "pow"),
    function(integer_to_binary_list),
    function(binary_list_to_integer),
)
