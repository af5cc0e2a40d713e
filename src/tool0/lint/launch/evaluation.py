"""Evaluates roslaunch's ``$(eval …)``, limited to arithmetic, texts and arguments.

roslaunch passes the expression to Python.  This module evaluates the syntax tree of the
expression directly, and supports only the constructs below.  Sizes are bounded, so that
every expression is evaluated quickly.
"""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, final

MAX_LENGTH: Final = 2000
"""Largest number of characters in an expression."""
MAX_TEXT: Final = 50_000
"""Largest number of characters in a text that an expression creates."""
MAX_BITS: Final = 4096
"""Largest size of a whole number [bits]."""

Function = Callable[..., object]

_OF_MATH: Final = (
    "acos acosh asin asinh atan atan2 atanh ceil copysign cos cosh degrees exp fabs"
    " floor fmod hypot isfinite isinf isnan log log10 log2 pow radians sin sinh"
    " sqrt tan tanh trunc"
)
_CONSTANTS: Final[dict[str, object]] = {
    "true": True,
    "false": False,
    "pi": math.pi,
    "e": math.e,
    "tau": math.tau,
    "inf": math.inf,
    "nan": math.nan,
}
METHODS: Final = frozenset(
    {
        *("capitalize", "count", "endswith", "find", "isdigit", "lower", "lstrip"),
        *("rstrip", "split", "startswith", "strip", "title", "upper"),
    }
)
"""Text methods whose result is not longer than the text."""
UNARY: Final[dict[type[ast.unaryop], Function]] = {
    ast.Not: operator.not_,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Invert: operator.invert,
}
COMPARE: Final[dict[type[ast.cmpop], Function]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda item, where: item in where,
    ast.NotIn: lambda item, where: item not in where,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}
_BINARY: Final[dict[type[ast.operator], Function]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
}


class EvaluationError(Exception):
    """Raised if the expression has no value.  The message contains the reason."""


@final
class NotUnderstoodError(EvaluationError):
    """Raised if the expression is not supported, but may have a value in roslaunch."""


def evaluate(
    expression: str,
    functions: Mapping[str, Function],
    argument: Callable[[str], object],
) -> str:
    """Return the value of ``expression`` as the text that roslaunch would write.

    Args:
        expression: The content of ``$(eval …)``.
        functions: Functions that take texts, by name.  The expression may call these
            functions.
        argument: Function that returns the value of a name.  The function raises
            KeyError if the name does not exist.

    Raises:
        EvaluationError: If the text is not an expression, has no value, or is not
            supported.
    """
    if len(expression) > MAX_LENGTH:
        raise EvaluationError(f"it is longer than {MAX_LENGTH} characters")
    if "__" in expression:
        raise EvaluationError("it must not contain a double underscore")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python warns of invalid escape sequences
            tree = ast.parse(expression.strip(), mode="eval")
        return str(_Evaluator(functions, argument).value(tree.body))
    except EvaluationError:
        raise
    except (SyntaxError, ValueError, TypeError, ArithmeticError) as error:
        raise EvaluationError(" ".join(str(error).split()) or repr(error)) from None
    except (RecursionError, MemoryError):
        raise EvaluationError("it is nested too deep") from None
    except (LookupError, AttributeError) as error:
        raise EvaluationError(str(error).strip("'\"")) from None


@final
@dataclass(frozen=True, slots=True)
class _Evaluator:
    """Evaluates the syntax tree of one expression."""

    of_texts: Mapping[str, Function]
    """Functions that take texts, by name."""
    argument: Callable[[str], object]

    def value(self, node: ast.expr) -> object:
        """Return the value of an expression."""
        match node:
            case ast.Constant(
                value=bool() | int() | float() | str() | None as constant
            ):
                return constant
            case ast.Name(id=name):
                return self._name(name)
            case ast.UnaryOp(op=op, operand=operand):
                return UNARY[type(op)](self.value(operand))
            case ast.BinOp(left=left, op=op, right=right):
                return binary(op, self.value(left), self.value(right))
            case ast.BoolOp(op=op, values=values):
                return self._either(isinstance(op, ast.Or), values)
            case ast.IfExp(test=test, body=body, orelse=otherwise):
                return self.value(body if self.value(test) else otherwise)
            case ast.Compare():
                return self._compare(node)
            case ast.Call(keywords=[]):
                return self._call(node.func, [self.value(arg) for arg in node.args])
            case ast.List(elts=items):
                return [self.value(item) for item in items]
            case ast.Tuple(elts=items):
                return tuple(self.value(item) for item in items)
            case ast.Subscript(value=whole, slice=index) if not isinstance(
                index, ast.Slice
            ):
                return _item(self.value(whole), self.value(index))
        raise _not_understood(node)

    def _name(self, name: str) -> object:
        if name in _CONSTANTS:
            return _CONSTANTS[name]
        try:
            return self.argument(name)
        except KeyError:
            raise EvaluationError(f"'{name}' has no value") from None

    def _either(self, is_or: bool, values: list[ast.expr]) -> object:
        result: object = None
        for item in values:
            result = self.value(item)
            if bool(result) is is_or:
                break
        return result

    def _compare(self, node: ast.Compare) -> bool:
        left = self.value(node.left)
        for op, operand in zip(node.ops, node.comparators, strict=True):
            right = self.value(operand)
            if not COMPARE[type(op)](left, right):
                return False
            left = right
        return True

    def _call(self, called: ast.expr, arguments: list[object]) -> object:
        match called:
            case ast.Name(id=name) if name in self.of_texts:
                if not all(isinstance(argument, str) for argument in arguments):
                    raise EvaluationError(f"{name}() takes texts")
                return self.of_texts[name](*arguments)
            case ast.Name(id=name) if name in _FUNCTIONS:
                if name in ("pow", "int") and len(arguments) > 1:
                    arguments = [_small(argument) for argument in arguments]
                return _FUNCTIONS[name](*arguments)
            case ast.Attribute(value=owner, attr=name) if name in METHODS:
                text = self.value(owner)
                if isinstance(text, str):
                    return getattr(text, name)(*arguments)
        raise _not_understood(called)


def _item(whole: object, index: object) -> object:
    if isinstance(whole, (str, list, tuple)) and isinstance(index, int):
        return whole[index]
    raise EvaluationError(f"{type(whole).__name__} has no element {index!r}")


def binary(op: ast.operator, left: object, right: object) -> object:
    """Return the result of an operator, provided that the result cannot be large."""
    for value in (left, right):
        _small(value)
    are_numbers = isinstance(left, int | float) and isinstance(right, int | float)
    match op:
        case ast.Pow() | ast.LShift() if are_numbers:
            if isinstance(left, int) and isinstance(right, int):
                is_power = isinstance(op, ast.Pow)
                _bound_bits(abs(right) * left.bit_length() if is_power else right)
        case ast.Add() if isinstance(left, str) and isinstance(right, str):
            _bound_text(len(left) + len(right))
        case ast.Mult() if not are_numbers:
            text, times = (left, right) if isinstance(left, str) else (right, left)
            if not (isinstance(text, str) and isinstance(times, int)):
                raise NotUnderstoodError(
                    "only numbers and texts can be multiplied here"
                )
            _bound_text(len(text) * max(times, 0))
        case ast.Add() if type(left) is type(right) is list:
            pass
        case _ if not are_numbers:
            names = f"{type(left).__name__} and {type(right).__name__}"
            raise EvaluationError(f"{names} cannot be combined here")
    if type(op) not in _BINARY:
        raise EvaluationError("an operator that is not supported here")
    return _small(_BINARY[type(op)](left, right))


def _small(value: object) -> object:
    if isinstance(value, int):
        _bound_bits(value.bit_length())
    return value


def _bound_bits(bits: int) -> None:
    if bits > MAX_BITS:
        raise EvaluationError(f"a number of more than {MAX_BITS} bits")


def _bound_text(length: int) -> None:
    if length > MAX_TEXT:
        raise EvaluationError(f"a text of more than {MAX_TEXT} characters")


def _round(number: float, digits: int | None = None) -> object:
    if digits is not None and abs(digits) > 400:  # beyond the range of a float
        raise EvaluationError(f"round() to {digits} digits")
    return round(number, digits)


_FUNCTIONS: Final[dict[str, Function]] = {
    **{name: getattr(math, name) for name in _OF_MATH.split()},
    **{f.__name__: f for f in (int, float, str, list, bool, len, abs, min, max)},
    "round": _round,
}


def _not_understood(node: ast.expr) -> NotUnderstoodError:
    shown = ast.unparse(node)
    shown = shown if len(shown) <= 40 else f"{shown[:37]}..."
    return NotUnderstoodError(
        f"'{shown}' is not understood here; understood are numbers, texts, arguments, "
        "operators, comparisons, the functions of math, and methods of texts"
    )
