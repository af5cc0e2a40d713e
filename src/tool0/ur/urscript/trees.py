"""From each rule of the grammar to a node of ``syntax``."""

from __future__ import annotations

import re
from typing import Any, Final, cast, final

from lark import Token, Transformer

from tool0.ur.urscript import syntax as s
from tool0.ur.urscript.errors import Place, URScriptError

INT_RANGE: Final = range(-(2**31), 2**31)
"""Integers of URScript have 32 bits."""
MAX_TEXT: Final = 1023
"""Longest string [bytes], as on the robot."""
_POSE: Final = "p"
_DIGITS: Final = re.compile("[0-9]{1,10}")

# Children are what the rules below return, mixed with tokens: lark types them as Any.
Children = list[Any]


def place(token: Token) -> Place:
    """Return where a token starts."""
    return Place(token.line or 1, token.column or 1)


@final
class Trees(Transformer[Token, s.Block]):
    """Builds the syntax tree while the program is parsed."""

    def start(self, children: Children) -> s.Block:
        return tuple(children)

    def block(self, children: Children) -> s.Block:
        return tuple(children)

    def assign(self, children: Children) -> s.Assign:
        scope, target, equal, value = children
        indexes: tuple[s.Expression, ...] = ()
        base = target
        if isinstance(target, s.Index):
            base, indexes = target.base, target.indexes
        if isinstance(target, s.PoseOf) and len(target.items) == 1:
            base, indexes = s.Name(target.at, _POSE), target.items
        if not isinstance(base, s.Name):
            raise URScriptError(
                "only a variable or an element of one can be assigned to", place(equal)
            )
        at = base.at if scope is None else place(scope)
        if scope is not None and indexes:
            raise URScriptError(f"'{scope}' declares a variable, not an element", at)
        declared = None if scope is None else cast("Any", str(scope))
        return s.Assign(at, declared, base.name, indexes, value)

    def evaluate(self, children: Children) -> s.Evaluate:
        value = children[0]
        if isinstance(value, s.Name):
            raise URScriptError(
                f"'{value.name}' alone does nothing; call a function with "
                f"{value.name}(), or assign to a variable with =",
                value.at,
            )
        if not isinstance(value, s.Call | s.Run | s.Join):
            raise URScriptError("this value is not used", value.at)
        return s.Evaluate(value.at, value)

    def return_(self, children: Children) -> s.Return:
        return s.Return(place(children[0]), children[1])

    def kill(self, children: Children) -> s.Kill:
        return s.Kill(place(children[0]), children[1])

    def keyword(self, children: Children) -> s.Simple:
        word = children[0]
        return s.Simple(place(word), cast("s.Keyword", str(word)))

    def if_(self, children: Children) -> s.If:
        word, *rest, otherwise = children
        branches = tuple(zip(rest[::2], rest[1::2], strict=True))
        return s.If(place(word), branches, otherwise or ())

    def while_(self, children: Children) -> s.While:
        word, condition, body = children
        return s.While(place(word), condition, body)

    def definition(self, children: Children) -> s.Definition:
        word, name, parameters, body = children
        return s.Definition(
            place(word), cast("Any", str(word)), str(name), parameters or (), body
        )

    def parameters(self, children: Children) -> tuple[s.Parameter, ...]:
        return tuple(children)

    def parameter(self, children: Children) -> s.Parameter:
        name, _, default = children
        return s.Parameter(place(name), str(name), default)

    def _chain(self, children: Children) -> s.Chain:
        first, *rest = children
        operands = tuple(
            s.Operand(place(operator), str(operator), value)
            for operator, value in zip(rest[::2], rest[1::2], strict=True)
        )
        return s.Chain(first.at, first, operands)

    expression = exclusive = conjunction = comparison = sum = product = _chain

    def not_(self, children: Children) -> s.Unary:
        return s.Unary(place(children[0]), "not", children[1])

    def sign(self, children: Children) -> s.Unary:
        return s.Unary(place(children[0]), str(children[0]), children[1])

    def indexed(self, children: Children) -> s.Expression:
        base, *rest = children
        groups: list[list[s.Expression]] = []
        for child in rest:
            if isinstance(child, Token):
                groups.append([])
            else:
                groups[-1].append(child)
        if isinstance(base, s.Name) and base.name == _POSE:
            base = s.PoseOf(base.at, tuple(groups.pop(0)))
        indexes = tuple(item for group in groups for item in group)
        return (
            s.Index(base.at, base, indexes) if indexes else cast("s.Expression", base)
        )

    def literal(self, children: Children) -> s.Literals:
        token = children[0]
        return s.Literals(place(token), _constant(token))

    def name(self, children: Children) -> s.Name:
        return s.Name(place(children[0]), str(children[0]))

    def call(self, children: Children) -> s.Call:
        name, *arguments = children
        given = tuple(item for item in arguments if item is not None)
        return s.Call(place(name), str(name), given)

    def argument(self, children: Children) -> s.Argument:
        value, equal, second = children
        if equal is None:
            return s.Argument(value.at, None, value)
        if not isinstance(value, s.Name):
            raise URScriptError(
                "an argument's name stands before '='; use '==' to compare",
                place(equal),
            )
        return s.Argument(value.at, value.name, second)

    def list_(self, children: Children) -> s.ListOf:
        opener, *items = children
        return s.ListOf(
            place(opener), tuple(item for item in items if item is not None)
        )

    def run(self, children: Children) -> s.Run:
        return s.Run(place(children[0]), str(children[1]))

    def join(self, children: Children) -> s.Join:
        return s.Join(place(children[0]), children[1])


def _constant(token: Token) -> s.Constant:
    match token.type:
        case "INTEGER":
            if not _DIGITS.fullmatch(token) or int(token) not in INT_RANGE:
                raise URScriptError("integers have 32 bits; add '.0'", place(token))
            return int(token)
        case "FLOAT":
            value = float(token)
            if value == float("inf"):
                raise URScriptError("this number is too large", place(token))
            return value
        case "STRING":  # strings are bytes; one character stands for each
            text = token[1:-1].encode().decode("latin-1")
            if len(text) > MAX_TEXT:
                raise URScriptError(
                    f"strings have at most {MAX_TEXT} bytes", place(token)
                )
            return text
        case _:
            return token.type == "TRUE"
