"""Conversion of each grammar rule to a node of ``syntax``."""

from __future__ import annotations

import re
from typing import Any, Final, cast, final

from lark import Token, Transformer

from tool0.ur.urscript import syntax as s
from tool0.ur.urscript.syntax import INT_RANGE, MAX_TEXT
from tool0.ur.urscript_errors import Place, URScriptError

_POSE: Final = "p"
_STRUCT: Final = "struct"
_PASS: Final = "pass"
_DIGITS: Final = re.compile("[0-9]{1,10}")

# Children are tokens and the results of the rules below; lark declares them as Any.
Children = list[Any]


def place(token: Token) -> Place:
    """Return the location where a token starts."""
    return Place(token.line or 1, token.column or 1)


@final
class Trees(Transformer[Token, s.Block]):
    """Builds the syntax tree during parsing."""

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

    def evaluate(self, children: Children) -> s.Evaluate | s.Simple:
        value = children[0]
        if isinstance(value, s.Name) and value.name == _PASS:
            return s.Simple(value.at, _PASS)
        if isinstance(value, s.Name):
            raise URScriptError(
                f"'{value.name}' alone does nothing; call a function with "
                f"{value.name}(), or assign to a variable with =",
                value.at,
            )
        if not isinstance(value, s.Call | s.Method | s.Run | s.Join):
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

    def element(self, children: Children) -> s.Expression:
        base, _, *items = children
        if isinstance(base, s.Name) and base.name == _POSE:
            return s.PoseOf(base.at, tuple(items))
        return _indexed(base, tuple(items))

    def member(self, children: Children) -> s.Expression:
        base, _, name = children
        return _indexed(base, (s.MemberName(place(name), str(name)),))

    def method(self, children: Children) -> s.Method:
        base, _, name, *arguments = children
        given = tuple(item for item in arguments if item is not None)
        return s.Method(place(name), base, str(name), given)

    def literal(self, children: Children) -> s.Literals:
        token = children[0]
        return s.Literals(place(token), _constant(token))

    def name(self, children: Children) -> s.Name:
        return s.Name(place(children[0]), str(children[0]))

    def call(self, children: Children) -> s.Call | s.StructOf:
        name, *arguments = children
        given = tuple(item for item in arguments if item is not None)
        if name == _STRUCT:
            return _struct(place(name), given)
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


def _indexed(base: s.Expression, indexes: tuple[s.Expression, ...]) -> s.Index:
    if isinstance(base, s.Index):
        return s.Index(base.at, base.base, base.indexes + indexes)
    return s.Index(base.at, base, indexes)


def _struct(at: Place, arguments: tuple[s.Argument, ...]) -> s.StructOf:
    names = tuple(item.name for item in arguments if item.name is not None)
    if not names or len(names) < len(arguments) or len(set(names)) < len(names):
        raise URScriptError("a struct has members with different names: a = 1, …", at)
    return s.StructOf(at, names, tuple(item.value for item in arguments))


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
        case "STRING":  # strings are bytes, each stored as one character
            text = token[1:-1].encode().decode("latin-1")
            if len(text) > MAX_TEXT:
                raise URScriptError(
                    f"strings have at most {MAX_TEXT} bytes", place(token)
                )
            return text
        case _:
            return token.type == "TRUE"
