"""Evaluates Python expressions as far as possible without executing them."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import TypeAlias, final

from tool0.errors import SourceLocation
from tool0.lint.launch.evaluation import COMPARE, UNARY, EvaluationError, binary
from tool0.lint.launch.python.grammar import SUBSTITUTIONS
from tool0.lint.launch.python.library import MAX_ITEMS, PATH_PARTS
from tool0.lint.launch.python.values import (
    Choice,
    Function,
    Made,
    Method,
    Name,
    Scope,
    Unknown,
    Value,
    is_text,
    same,
    truth,
)

Comprehension: TypeAlias = ast.ListComp | ast.SetComp | ast.GeneratorExp | ast.DictComp


@final
@dataclass(frozen=True, slots=True)
class Call:
    """A call of a function, with its arguments."""

    function: Value
    arguments: tuple[Value, ...]
    keywords: Mapping[str, Value]
    location: SourceLocation
    places: Mapping[str, SourceLocation]
    is_whole: bool
    """Whether all arguments are known."""


@final
@dataclass(frozen=True, slots=True)
class Expressions:
    """Evaluates the expressions of one file."""

    call: Callable[[Call], Value]
    look_up: Callable[[str, Scope], Value]
    misused: Callable[[Made, SourceLocation], None]
    """Function that is called with each substitution that is used as text before the
    substitution has a value."""
    locate: Callable[[ast.AST], SourceLocation]
    spend: Callable[[], None]
    """Function that counts one step and raises an error if there were too many
    steps."""

    def value(self, node: ast.expr, scope: Scope) -> Value:
        """Return the value of an expression."""
        self.spend()
        match node:
            case ast.Constant(value=constant):
                return constant
            case ast.Name(id=name):
                return self.look_up(name, scope)
            case ast.Attribute(value=owner, attr=name):
                return _attribute(self.value(owner, scope), name)
            case ast.Call():
                return self.call(self._call(node, scope))
            case ast.List(elts=items) | ast.Set(elts=items):
                return list(self._items(items, scope))
            case ast.Tuple(elts=items):
                return tuple(self._items(items, scope))
            case ast.Dict():
                return self._dict(node, scope)
            case ast.JoinedStr():
                return self._f_string(node, scope)
            case ast.BinOp(left=left, op=op, right=right):
                first, second = self.value(left, scope), self.value(right, scope)
                return self.combined(op, first, second, self.locate(node))
            case ast.BoolOp() | ast.UnaryOp() | ast.Compare() | ast.IfExp():
                return self._logic(node, scope)
            case ast.Subscript(value=whole, slice=index):
                return self._item(self.value(whole, scope), index, scope)
            case ast.ListComp() | ast.SetComp() | ast.GeneratorExp() | ast.DictComp():
                return self._comprehension(node, scope)
            case ast.Lambda():
                return Function(node, scope)
            case ast.NamedExpr(target=ast.Name(id=name), value=inner):
                scope.names[name] = result = self.value(inner, scope)
                return result
        return Unknown(f"'{_short(node)}' is not read")

    def combined(
        self, op: ast.operator, left: Value, right: Value, where: SourceLocation
    ) -> Value:
        """Return the result of an operator."""
        if isinstance(op, ast.Div) and _is_path(left):
            if isinstance(left, PurePath) and is_text(right):
                return left / str(right)
            if isinstance(left, Made):
                parts = {"substitutions": [left, right]}
                return Made("PathJoinSubstitution", where, parts)
        if isinstance(op, ast.Add) and isinstance(left, list | tuple):
            return _joined(left, right)
        if isinstance(op, ast.Add) and isinstance(right, list | tuple):
            return _joined([left], right)
        if isinstance(op, ast.BitOr) and isinstance(left, dict):
            return {**left, **right} if isinstance(right, dict) else left
        for one, other in ((left, right), (right, left)):
            if isinstance(one, str) and isinstance(other, Made):
                self._refuse(other, where)
        if any(isinstance(v, Unknown | Choice | Made | Name) for v in (left, right)):
            return Unknown("an operation with something unknown")
        try:
            return binary(op, left, right)
        except (EvaluationError, TypeError, ValueError, ArithmeticError) as error:
            return Unknown(str(error))

    def _call(self, node: ast.Call, scope: Scope) -> Call:
        keywords: dict[str, Value] = {}
        places: dict[str, SourceLocation] = {}
        function = self.value(node.func, scope)
        arguments = tuple(self._items(node.args, scope))
        is_whole = not any(isinstance(item, ast.Starred) for item in node.args)
        for keyword in node.keywords:
            value = self.value(keyword.value, scope)
            if keyword.arg is not None:
                keywords[keyword.arg] = value
                places[keyword.arg] = self.locate(keyword.value)
            elif isinstance(value, dict) and all(isinstance(k, str) for k in value):
                keywords |= value
            else:
                is_whole = False
        where = self.locate(node)
        return Call(function, arguments, keywords, where, places, is_whole)

    def _items(self, nodes: list[ast.expr], scope: Scope) -> Iterator[Value]:
        for node in nodes:
            if not isinstance(node, ast.Starred):
                yield self.value(node, scope)
                continue
            value = self.value(node.value, scope)
            if isinstance(value, list | tuple):
                yield from value
            else:
                yield Choice((value,))

    def _dict(self, node: ast.Dict, scope: Scope) -> Value:
        result: dict[Value, Value] = {}
        for key, item in zip(node.keys, node.values, strict=True):
            value = self.value(item, scope)
            if key is None:
                result |= value if isinstance(value, dict) else {}
                continue
            name = self.value(key, scope)
            try:
                result[name] = value
            except TypeError:
                return Unknown(f"'{_short(key)}' cannot be a key")
        return result

    def _f_string(self, node: ast.JoinedStr, scope: Scope) -> Value:
        parts = []
        for item in node.values:
            if not isinstance(item, ast.FormattedValue):
                parts.append(self.value(item, scope))
                continue
            value = self.value(item.value, scope)
            if isinstance(value, Made):
                self._refuse(value, self.locate(node))
            is_plain = is_text(value) or isinstance(value, bool | int | float)
            if not is_plain or item.format_spec is not None or item.conversion > 0:
                return Unknown(f"'{_short(node)}' has no value here")
            parts.append(str(value))
        return "".join(str(part) for part in parts)

    def _logic(self, node: ast.expr, scope: Scope) -> Value:
        """Return the value of ``and``, ``or``, ``not``, a comparison or ``if``."""
        match node:
            case ast.BoolOp(op=op, values=values):
                for item in values:
                    value = self.value(item, scope)
                    is_true = truth(value)
                    if is_true is None or is_true is isinstance(op, ast.Or):
                        return value
                return value
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                is_true = truth(self.value(operand, scope))
                return (
                    Unknown("not of something unknown")
                    if is_true is None
                    else (not is_true)
                )
            case ast.UnaryOp(op=op, operand=operand):
                value = self.value(operand, scope)
                is_number = isinstance(value, int | float)
                return UNARY[type(op)](value) if is_number else Unknown("no number")
            case ast.IfExp(test=test, body=body, orelse=other):
                is_true = truth(self.value(test, scope))
                if is_true is not None:
                    return self.value(body if is_true else other, scope)
                return choice(self.value(body, scope), self.value(other, scope))
            case ast.Compare():
                return self._compare(node, scope)
        raise AssertionError(node)

    def _compare(self, node: ast.Compare, scope: Scope) -> Value:
        values = [self.value(item, scope) for item in (node.left, *node.comparators)]
        for op, (left, right) in zip(node.ops, zip(values, values[1:])):  # noqa: B905,RUF007
            unknown = Unknown | Choice if right is None else Unknown | Choice | Made
            if isinstance(left, unknown) or isinstance(right, unknown):
                return Unknown("a comparison with something unknown")
            try:
                if not COMPARE[type(op)](left, right):
                    return False
            except TypeError as error:
                return Unknown(str(error))
        return True

    def _item(self, whole: Value, index: ast.expr, scope: Scope) -> Value:
        if isinstance(index, ast.Slice):
            parts = (index.lower, index.upper, index.step)
            bounds = [None if p is None else self.value(p, scope) for p in parts]
            numbers = [b if isinstance(b, int) else None for b in bounds]
            if isinstance(whole, str | list | tuple) and numbers == bounds:
                return whole[slice(*numbers)]
            return Unknown("a part of something unknown")
        key = self.value(index, scope)
        if isinstance(whole, Made) and whole.name == "launch_configurations":
            return self.call(
                Call(Method(whole, "get"), (key,), {}, whole.location, {}, True)
            )
        try:
            if isinstance(whole, dict):
                return whole[key]
            if isinstance(whole, str | list | tuple) and isinstance(key, int):
                return whole[key]
        except (LookupError, TypeError):
            pass
        return Unknown(f"[{_short(index)}] is unknown")

    def _comprehension(self, node: Comprehension, scope: Scope) -> Value:
        inner = Scope(outer=scope)
        made: list[Value] = []
        pairs: dict[Value, Value] = {}

        def add() -> None:
            if isinstance(node, ast.DictComp):
                key = self.value(node.key, inner)
                if isinstance(key, str | int):
                    pairs[key] = self.value(node.value, inner)
            else:
                made.append(self.value(node.elt, inner))

        def loop(generators: list[ast.comprehension]) -> bool:
            if not generators:
                add()
                return True
            first, *others = generators
            items = self.value(first.iter, inner)
            for item in iterated(items):
                assign(first.target, item, inner)
                tests = [truth(self.value(test, inner)) for test in first.ifs]
                if None in tests:
                    return False
                if False not in tests and not loop(others):
                    return False
            return not isinstance(items, Unknown | Choice | Made)

        if not loop(node.generators):
            return Unknown(f"'{_short(node)}' goes over something unknown")
        return pairs if isinstance(node, ast.DictComp) else made

    def _refuse(self, value: Made, where: SourceLocation) -> None:
        if value.name in SUBSTITUTIONS:
            self.misused(value, where)


def choice(*values: Value) -> Value:
    """Return the only value, or a ``Choice`` if there are different values."""
    first, *others = values
    if all(same(first, other) for other in others):
        return first
    return Choice(values)


def iterated(value: Value) -> list[Value]:
    """Return the items of a loop, or an empty list if they are unknown."""
    if isinstance(value, dict | list | tuple | str):
        return list(value)
    return []


def assign(target: ast.expr, value: Value, scope: Scope) -> None:
    """Assign a value to names.  The caller handles all other targets."""
    match target:
        case ast.Name(id=name):
            scope.names[name] = value
        case ast.Tuple(elts=targets) | ast.List(elts=targets):
            is_known = isinstance(value, list | tuple) and len(value) == len(targets)
            values = value if is_known else [Unknown("unpacked")] * len(targets)
            for one, item in zip(targets, values, strict=True):  # type: ignore[call-overload]
                assign(one, item, scope)


def _attribute(owner: Value, name: str) -> Value:
    match owner:
        case Name(dotted=dotted):
            return Name(f"{dotted}.{name}")
        case PurePath() if name in PATH_PARTS:
            return getattr(owner, name)
        case Made(name="LaunchContext") if name == "launch_configurations":
            return Made(name, owner.location)
        case Unknown() | Choice() | None:
            return Unknown(f".{name} of something unknown")
    return Method(owner, name)


def _joined(left: list[Value] | tuple[Value, ...], right: Value) -> Value:
    """Return ``left`` joined with ``right``, whose value may be unknown."""
    if isinstance(right, list | tuple):
        if len(left) + len(right) > MAX_ITEMS:
            return Unknown(f"more than {MAX_ITEMS} items")
        return [*left, *right] if isinstance(left, list) else (*left, *right)
    return [*left, right]


def _is_path(value: Value) -> bool:
    is_made = isinstance(value, Made) and value.name in (
        "PathSubstitution",
        "PathJoinSubstitution",
    )
    return is_made or isinstance(value, PurePath)


def _short(node: ast.AST) -> str:
    text = ast.unparse(node)
    return text if len(text) <= 40 else f"{text[:37]}..."
