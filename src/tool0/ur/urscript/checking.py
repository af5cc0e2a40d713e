"""Checks a complete program before any part of it is executed."""

from __future__ import annotations

from typing import Final, NoReturn, TypeAlias, cast, final

from tool0.errors import nearest_name
from tool0.ur.urscript import syntax as s
from tool0.ur.urscript.functions import Function, Parameter
from tool0.ur.urscript.library.table import library
from tool0.ur.urscript.lists import list_method
from tool0.ur.urscript.scopes import Scope
from tool0.ur.urscript.unsupported import reason_against
from tool0.ur.urscript.values import (
    ARITHMETIC,
    Member,
    Value,
    boolean,
    checked_list,
    checked_pose,
    element,
    negated,
    positive,
    truth,
)
from tool0.ur.urscript_errors import Place, URScriptError, ValueProblem


@final
class _Unknown:
    """A value that is known only when the program runs."""


_UNKNOWN: Final = _Unknown()
_Known: TypeAlias = Value | _Unknown


@final
class Checker:
    """Checks a program in order and raises URScriptError at the first mistake."""

    def __init__(self, program: str, *, has_servers: bool = False) -> None:
        """Prepare to check a program.

        Args:
            program: Name of the program, for error messages.
            has_servers: Whether the program may contain handles of XML-RPC servers.
                With such handles, a method that lists do not have may be a function of
                a server.
        """
        self._program = program
        self._has_servers = has_servers
        self._scope: Scope
        self._loops = 0

    def check(self, scope: Scope) -> None:
        """Check the body of a definition and the definitions inside this body."""
        outer = getattr(self, "_scope", None), self._loops
        self._scope, self._loops = scope, 0
        definition = scope.definition
        self._check_parameters(definition)
        self._block(definition.body)
        if outer[0] is not None:
            self._scope, self._loops = outer[0], outer[1]

    def check_block(self, scope: Scope, block: s.Block) -> None:
        """Check additional statements of a definition's body."""
        self._scope = scope
        self._block(block)

    def _check_parameters(self, definition: s.Definition) -> None:
        if definition.kind != "def" and definition.parameters:
            message = f"a '{definition.kind}' has no parameters"
            self._fail(message, definition.parameters[0].at)
        names: set[str] = set()
        has_default = False
        for item in definition.parameters:
            if item.name in names:
                self._fail(f"two parameters are named '{item.name}'", item.at)
            names.add(item.name)
            if item.default is not None:
                has_default = True
                self._fold(item.default)
            elif has_default:
                self._fail(
                    f"parameter '{item.name}' needs a default, as those before it",
                    item.at,
                )

    def _fail(self, message: str, at: Place, *, key: str = "") -> NoReturn:
        raise URScriptError(message, at, self._program, key)

    # ---- statements -----------------------------------------------------------------

    def _block(self, block: s.Block) -> None:
        for statement in block:
            self._statement(statement)

    def _statement(self, statement: s.Statement) -> None:
        match statement:
            case s.Assign():
                call = self._scope.output_call(statement)
                if call is None:
                    self._assign(statement)
                else:
                    self._statement(call)
            case s.Evaluate(value=value) | s.Kill(handle=value):
                self._fold(value)
            case s.If(branches=branches, otherwise=otherwise):
                for condition, body in branches:
                    self._condition(condition)
                    self._block(body)
                self._block(otherwise)
            case s.While(condition=condition, body=body):
                self._condition(condition)
                self._loops += 1
                self._block(body)
                self._loops -= 1
            case s.Return(value=value):
                if value is not None:
                    self._fold(value)
            case s.Simple(at=at, keyword=("break" | "continue") as word):
                if not self._loops:
                    self._fail(f"'{word}' outside of a loop", at)
            case s.Definition(at=at, kind=kind, name=name):
                if kind == "sec":
                    self._fail("a 'sec' must not be inside another program", at)
                if self._scope.functions[name] is not statement:
                    self._fail(f"'{name}' is defined twice", at)
                self.check(self._scope.inner(statement))
            case _:
                pass

    def _assign(self, statement: s.Assign) -> None:
        value = self._fold(statement.value)
        if value is None:
            self._fail("there is no value to assign", statement.at)
        if statement.indexes:
            self._variable(s.Name(statement.at, statement.name))
            for index in statement.indexes:
                self._fold(index)

    def _condition(self, condition: s.Expression) -> None:
        value = self._fold(condition)
        if not isinstance(value, _Unknown):
            self._try(lambda: truth(value), condition.at)

    # ---- expressions ----------------------------------------------------------------

    def _fold(self, expression: s.Expression) -> _Known:
        """Check an expression; return its value if the expression is constant."""
        match expression:
            case s.Literals(value=value):
                return value
            case s.Name():
                self._variable(expression)
            case s.ListOf(items=items, at=at):
                return self._items(items, at, is_pose=False)
            case s.PoseOf(items=items, at=at):
                return self._pose(items, at)
            case s.StructOf(values=values):
                for item in values:
                    self._fold(item)
            case s.MemberName(name=name):
                return Member(name)
            case s.Method():
                self._method(expression)
            case s.Index():
                return self._element(expression)
            case s.Unary():
                return self._unary(expression)
            case s.Chain():
                return self._chain(expression)
            case s.Call():
                self._call(expression)
            case s.Run(at=at, name=name):
                found = self._scope.find(name)
                if found is None or found[0].kind != "thread":
                    threads = [
                        item
                        for item in self._scope.visible_functions()
                        if (known := self._scope.find(item))
                        and known[0].kind == "thread"
                    ]
                    self._fail(f"unknown thread '{name}'" + _near(name, threads), at)
            case s.Join(handle=handle):
                self._fold(handle)
        return _UNKNOWN

    def _variable(self, name: s.Name) -> None:
        scope = self._scope
        if name.name in scope.locals or name.name in scope.globals:
            return
        if scope.find(name.name) or name.name in library():
            self._fail(
                f"'{name.name}' is a function; call it with {name.name}(…)", name.at
            )
        known = [*scope.locals, *scope.globals, "True", "False"]
        message = f"unknown variable '{name.name}'" + _near(name.name, known)
        self._fail(message, name.at, key=_not_found(name.name))

    def _items(
        self, items: tuple[s.Expression, ...], at: Place, *, is_pose: bool
    ) -> _Known:
        values = [self._fold(item) for item in items]
        if any(isinstance(value, _Unknown) for value in values):
            return _UNKNOWN
        make = checked_pose if is_pose else checked_list
        return self._try(lambda: make(cast("list[Value]", values)), at)

    def _pose(self, items: tuple[s.Expression, ...], at: Place) -> _Known:
        if len(items) == 1 and self._has_p():
            return self._element(s.Index(at, s.Name(at, "p"), items))
        if len(items) != 6:
            self._fail(f"a pose has 6 numbers, not {len(items)}", at)
        return self._items(items, at, is_pose=True)

    def _has_p(self) -> bool:
        return "p" in self._scope.locals or "p" in self._scope.globals

    def _element(self, expression: s.Index) -> _Known:
        value = self._fold(expression.base)
        for index in expression.indexes:
            position = self._fold(index)
            if isinstance(value, _Unknown) or isinstance(position, _Unknown):
                value = _UNKNOWN
                continue
            known, k = value, position
            value = self._try(lambda known=known, k=k: element(known, k), index.at)
        return value

    def _unary(self, expression: s.Unary) -> _Known:
        value = self._fold(expression.operand)
        if isinstance(value, _Unknown):
            return value
        match expression.operator:
            case "not":
                return self._try(lambda: not boolean("not", value), expression.at)
            case "-":
                return self._try(lambda: negated(value), expression.at)
            case _:
                return self._try(lambda: positive(value), expression.at)

    def _chain(self, expression: s.Chain) -> _Known:
        value = self._fold(expression.first)
        for operand in expression.rest:
            value = self._applied(value, operand)
        return value

    def _applied(self, value: _Known, operand: s.Operand) -> _Known:
        other = self._fold(operand.value)
        word = operand.operator
        if word in ARITHMETIC:
            if isinstance(value, _Unknown) or isinstance(other, _Unknown):
                return _UNKNOWN
            return self._try(lambda: ARITHMETIC[word](value, other), operand.at)
        for item in (value, other):
            if not isinstance(item, _Unknown):
                self._try(lambda item=item: boolean(word, item), operand.at)
        return _UNKNOWN

    def _try(self, compute: object, at: Place) -> Value:
        try:
            return cast("Value", compute())  # type: ignore[operator]
        except ValueProblem as problem:
            self._fail(str(problem), at)

    def _method(self, call: s.Method) -> None:
        self._fold(call.base)
        for argument in call.arguments:
            self._fold(argument)
        try:
            method = list_method(call.name, len(call.arguments))
        except ValueProblem as problem:
            if self._has_servers:  # it may be a server's function
                return
            self._fail(str(problem), call.at)
        base = call.base.base if isinstance(call.base, s.Index) else call.base
        if method.changes and not isinstance(base, s.Name):
            self._fail(f"'{call.name}' changes a list, which is a variable", call.at)

    # ---- calls ----------------------------------------------------------------------

    def _call(self, call: s.Call) -> None:
        values = [self._fold(argument.value) for argument in call.arguments]
        found = self._scope.find(call.name)
        if found is not None:
            definition = found[0]
            if definition.kind == "thread":
                self._fail(f"'{call.name}' is a thread; start it with 'run'", call.at)
            names = [item.name for item in definition.parameters]
            required = {i.name for i in definition.parameters if i.default is None}
            self._bind(call, names, required)
            return
        function = library().get(call.name)
        if function is None:
            self._unknown_function(call)
        if function.is_physical and self._is_secondary():
            self._fail(
                f"'{call.name}' takes time of the robot: a 'sec' must not call it",
                call.at,
            )
        names = [item.name for item in function.parameters]
        required = {item.name for item in function.parameters if item.is_required}
        positions = self._bind(call, names, required, function)
        for argument, value, k in zip(call.arguments, values, positions, strict=True):
            self._argument(call, function.parameters[k], argument, value)

    def _is_secondary(self) -> bool:
        scope: Scope | None = self._scope
        while scope is not None:
            if scope.definition.kind == "sec":
                return True
            scope = scope.parent
        return False

    def _unknown_function(self, call: s.Call) -> NoReturn:
        reason = reason_against(call.name)
        if reason is not None:
            self._fail(f"'{call.name}' is not supported: {reason}", call.at)
        known = [*self._scope.visible_functions(), *library()]
        message = f"unknown function '{call.name}'" + _near(call.name, known)
        self._fail(message, call.at, key=_not_found(call.name))

    def _bind(
        self,
        call: s.Call,
        names: list[str],
        required: set[str],
        function: Function | None = None,
    ) -> list[int]:
        """Return the index of the parameter that each argument sets."""
        positions: list[int] = []
        for argument in call.arguments:
            name = argument.name
            if name is None:
                if len(positions) >= len(names):
                    count = len(names)
                    plural = "s" * (count != 1)
                    self._fail(
                        f"'{call.name}' takes {count} argument{plural}, not "
                        f"{len(call.arguments)}" + _usage(function),
                        argument.at,
                    )
                if any(item.name for item in call.arguments[: len(positions)]):
                    self._fail("named arguments come last", argument.at)
                positions.append(len(positions))
            elif name not in names:
                self._fail(
                    f"'{call.name}' has no parameter '{name}'"
                    + (_near(name, names) or _usage(function)),
                    argument.at,
                )
            else:
                positions.append(names.index(name))
            if positions[-1] in positions[:-1]:
                name = names[positions[-1]]
                self._fail(f"argument '{name}' is given twice", argument.at)
        given = {names[k] for k in positions}
        missing = [name for name in names if name in required - given]
        if missing:
            words = ", ".join(f"'{name}'" for name in missing)
            self._fail(f"'{call.name}' needs {words}" + _usage(function), call.at)
        return positions

    def _argument(
        self, call: s.Call, parameter: Parameter, argument: s.Argument, value: _Known
    ) -> None:
        kind, node = parameter.kind, argument.value
        problem: str | None = None
        if not isinstance(value, _Unknown):
            try:
                kind.convert(value)
            except ValueProblem as error:
                problem = str(error)
        elif (
            isinstance(node, s.ListOf)
            and kind.sizes
            and len(node.items) not in kind.sizes
        ):
            problem = f"{kind.words} is needed, not a list of {len(node.items)}"
        if problem is not None:
            message = f"argument '{parameter.name}' of {call.name}: {problem}"
            self._fail(message, argument.at)


def _not_found(name: str) -> str:
    """Return the message of UR's controller for an unknown name."""
    return f"compile_error_name_not_found:{name}:"


def _near(name: str, valid: list[str]) -> str:
    near = nearest_name(name, valid)
    return f"; did you mean '{near}'?" if near else ""


def _usage(function: Function | None) -> str:
    return f": {function.signature}" if function else ""
