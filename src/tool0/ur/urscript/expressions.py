"""Compiles expressions to closures.

Only expressions that may wait are compiled to coroutines: library functions that take
time, the program's functions, and expressions that contain such calls. All other
expressions are compiled to ordinary functions.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any, cast, final

from tool0.errors import Tool0Error
from tool0.ur.urscript import syntax as s
from tool0.ur.urscript.code import (
    CallFrame,
    Code,
    Codes,
    Node,
    Run,
    Site,
    charged,
    combined,
    evaluated,
)
from tool0.ur.urscript.functions import Function, Parameter
from tool0.ur.urscript.library.table import library
from tool0.ur.urscript.lists import list_method
from tool0.ur.urscript.remote import CLOSE, RemoteServer
from tool0.ur.urscript.remote_values import received, sent
from tool0.ur.urscript.scopes import Scope
from tool0.ur.urscript.values import (
    ARITHMETIC,
    Handle,
    Member,
    Value,
    boolean,
    checked_list,
    checked_pose,
    checked_struct,
    described,
    element,
    negated,
    positive,
    with_element,
)
from tool0.ur.urscript_errors import Place, URScriptError, ValueProblem


@final
class Expressions:
    """Compiles the expressions of a definition."""

    def __init__(self, program: str, scope: Scope, codes: Codes) -> None:
        self._program = program
        self._scope = scope
        self._codes = codes

    def error(self, problem: Exception | str, at: Place) -> URScriptError:
        """Return a problem as an error that contains its location in the program."""
        return URScriptError(str(problem), at, self._program)

    def node(self, expression: s.Expression) -> Node:
        """Compile an expression to a closure."""
        match expression:
            case s.Literals(value=value):
                return Node(lambda frame: value, is_async=False)
            case s.Name():
                return self._name(expression)
            case s.ListOf(items=items, at=at):
                return self._made([self.node(x) for x in items], checked_list, at)
            case s.PoseOf(items=items, at=at):
                if len(items) == 1:  # an element of a variable named p
                    return self._index(s.Index(at, s.Name(at, "p"), items))
                return self._made([self.node(x) for x in items], checked_pose, at)
            case s.StructOf(at=at, names=names, values=values):
                nodes = [self.node(x) for x in values]
                return self._made(nodes, partial(checked_struct, names), at)
            case s.MemberName(name=name):
                member = Member(name)
                return Node(lambda frame: member, is_async=False)
            case s.Index():
                return self._index(expression)
            case s.Method():
                return self._method(expression)
            case s.Unary():
                return self._unary(expression)
            case s.Chain():
                return self._chain(expression)
            case s.Call():
                return self._call(expression)
            case s.Run():
                return self._run_thread(expression)
            case s.Join():
                return self._join(expression)

    def _name(self, expression: s.Name) -> Node:
        name, at = expression.name, expression.at
        missing = f"variable '{name}' has no value yet"
        if name in self._scope.locals:

            def run(frame: CallFrame) -> Value:
                try:
                    return frame.locals[name]
                except KeyError:
                    raise self.error(missing, at) from None

        else:

            def run(frame: CallFrame) -> Value:
                try:
                    return frame.globals[name]
                except KeyError:
                    raise self.error(missing, at) from None

        return Node(run, is_async=False)

    def _made(
        self, nodes: list[Node], make: Callable[[list[Value]], Value], at: Place
    ) -> Node:
        def combine(frame: CallFrame, values: list[Value]) -> Value:
            try:
                return charged(frame, make(values))
            except ValueProblem as problem:
                raise self.error(problem, at) from None

        return combined(nodes, combine)

    def _index(self, expression: s.Index) -> Node:
        places = [index.at for index in expression.indexes]
        nodes = [self.node(expression.base), *map(self.node, expression.indexes)]

        def combine(frame: CallFrame, values: list[Value]) -> Value:
            value = values[0]
            for index, at in zip(values[1:], places, strict=True):
                try:
                    value = element(value, index)
                except ValueProblem as problem:
                    raise self.error(problem, at) from None
            return value

        return combined(nodes, combine)

    def _method(self, call: s.Method) -> Node:
        """Compile a call of a list's method or of a server's function."""
        nodes = [self.node(call.base), *map(self.node, call.arguments)]
        whole = call.base
        base, places = (
            (whole.base, whole.indexes) if isinstance(whole, s.Index) else (whole, ())
        )
        indexes = [self.node(item) for item in places]

        async def apply(
            frame: CallFrame, value: Value, arguments: list[Value]
        ) -> Value:
            """Return the method's result; assign a changed list to its variable."""
            if type(value) is not tuple:
                raise ValueProblem(f"{described(value)} has no methods; a list has")
            method = list_method(call.name, len(arguments))
            changed, result = method.apply(value, arguments)
            if method.changes:
                assert isinstance(base, s.Name)  # checked
                is_local = base.name in self._scope.locals
                variables = frame.locals if is_local else frame.globals
                path = await evaluated(indexes, frame)
                old = variables[base.name]
                new = with_element(old, path, changed) if path else changed
                variables[base.name] = charged(frame, new)
            return charged(frame, result)

        async def run(frame: CallFrame) -> Value:
            value, *arguments = await evaluated(nodes, frame)
            try:
                if isinstance(value, RemoteServer):
                    return await _remote(frame, value, call.name, arguments)
                return await apply(frame, value, arguments)
            except ValueProblem as problem:
                raise self.error(f"{call.name}: {problem}", call.at) from None

        return Node(run, is_async=True)

    def _unary(self, expression: s.Unary) -> Node:
        at = expression.at
        compute: Callable[[Value], Value]
        match expression.operator:
            case "not":
                compute = _inverted
            case "-":
                compute = negated
            case _:
                compute = positive

        def combine(frame: CallFrame, values: list[Value]) -> Value:
            try:
                return compute(values[0])
            except ValueProblem as problem:
                raise self.error(problem, at) from None

        return combined([self.node(expression.operand)], combine)

    # ---- chains ---------------------------------------------------------------------

    def _chain(self, expression: s.Chain) -> Node:
        first = self.node(expression.first)
        rest = [self.node(operand.value) for operand in expression.rest]
        words = [operand.operator for operand in expression.rest]
        places = [operand.at for operand in expression.rest]
        if words[0] in {"and", "or"}:
            return self._until(words[0], [first, *rest], places)
        if words[0] == "xor":
            return self._exclusive([first, *rest], places)
        applies = [ARITHMETIC[word] for word in words]
        if len(rest) == 1 and not (first.is_async or rest[0].is_async):
            return self._pair(first.run, applies[0], rest[0].run, places[0])

        def combine(frame: CallFrame, values: list[Value]) -> Value:
            total = values[0]
            for apply, value, at in zip(applies, values[1:], places, strict=True):
                try:
                    total = charged(frame, apply(total, value))
                except ValueProblem as problem:
                    raise self.error(problem, at) from None
            return total

        return combined([first, *rest], combine)

    def _pair(
        self, left: Run, apply: Callable[[Value, Value], Value], right: Run, at: Place
    ) -> Node:
        def run(frame: CallFrame) -> Value:
            a, b = left(frame), right(frame)
            try:
                return charged(frame, apply(a, b))
            except ValueProblem as problem:
                raise self.error(problem, at) from None

        return Node(run, is_async=False)

    def _until(self, word: str, nodes: list[Node], places: list[Place]) -> Node:
        """Compile ``and`` or ``or``, which evaluate only the necessary operands."""
        decisive = word == "or"
        located = list(zip(nodes, [places[0], *places], strict=True))

        def checked(value: Value, at: Place) -> bool:
            try:
                return boolean(word, value)
            except ValueProblem as problem:
                raise self.error(problem, at) from None

        if any(node.is_async for node in nodes):

            async def run_async(frame: CallFrame) -> Value:
                for node, at in located:
                    value = node.run(frame)
                    if node.is_async:
                        value = await value
                    if checked(value, at) is decisive:
                        return decisive
                return not decisive

            return Node(run_async, is_async=True)

        def run(frame: CallFrame) -> Value:
            for node, at in located:
                if checked(node.run(frame), at) is decisive:
                    return decisive
            return not decisive

        return Node(run, is_async=False)

    def _exclusive(self, nodes: list[Node], places: list[Place]) -> Node:
        def combine(frame: CallFrame, values: list[Value]) -> Value:
            total = False
            for value, at in zip(values, [places[0], *places], strict=True):
                try:
                    total ^= boolean("xor", value)
                except ValueProblem as problem:
                    raise self.error(problem, at) from None
            return total

        return combined(nodes, combine)

    # ---- calls ----------------------------------------------------------------------

    def _call(self, call: s.Call) -> Node:
        nodes = [self.node(argument.value) for argument in call.arguments]
        code = self._codes.find(self._scope, call.name)
        if code is not None:
            names = [item.name for item in code.definition.parameters]
            return self._call_code(call, code, _positions(call, names), nodes)
        function = library()[call.name]
        names = [item.name for item in function.parameters]
        positions = _positions(call, names)
        convert = self._converter(call, function, positions)
        if function.is_async:
            return self._call_async(call, function, nodes, convert)
        compute, takes_thread = function.call, function.takes_thread
        cost = function.cost

        def combine(frame: CallFrame, values: list[Value]) -> Value:
            arguments = convert(values)
            frame.thread.left -= cost
            try:
                if takes_thread:
                    return cast("Value", compute(frame.thread, *arguments))
                return charged(frame, cast("Value", compute(*arguments)))
            except URScriptError:
                raise
            except (ValueProblem, Tool0Error) as problem:
                raise self.error(f"{call.name}: {problem}", call.at) from None

        return combined(nodes, combine)

    def _converter(
        self, call: s.Call, function: Function, positions: list[int]
    ) -> Callable[[list[Value]], list[Any]]:
        parameters = function.parameters
        places = [argument.at for argument in call.arguments]
        defaults = [item.default for item in parameters]

        def convert(values: list[Value]) -> list[Any]:
            arguments = list(defaults)
            for k, value, at in zip(positions, values, places, strict=True):
                parameter: Parameter = parameters[k]
                try:
                    arguments[k] = parameter.kind.convert(value)
                except ValueProblem as problem:
                    message = f"argument '{parameter.name}' of {call.name}: {problem}"
                    raise self.error(message, at) from None
            return arguments

        return convert

    def _call_async(
        self,
        call: s.Call,
        function: Function,
        nodes: list[Node],
        convert: Callable[[list[Value]], list[Any]],
    ) -> Node:
        async def run(frame: CallFrame) -> Value:
            arguments = convert(await evaluated(nodes, frame))
            caller: object = frame.thread
            if function.takes_site:
                caller = Site(frame, self._scope, self._codes)
            action = cast("Awaitable[Value]", function.call(caller, *arguments))
            try:
                return await frame.thread.timed(action)
            except URScriptError:
                raise
            except (ValueProblem, Tool0Error) as problem:
                raise self.error(f"{call.name}: {problem}", call.at) from None

        return Node(run, is_async=True)

    def _call_code(
        self, call: s.Call, code: Code, positions: list[int], nodes: list[Node]
    ) -> Node:
        names = [code.definition.parameters[k].name for k in positions]

        async def run(frame: CallFrame) -> Value:
            values = await evaluated(nodes, frame)
            arguments = dict(zip(names, values, strict=True))
            try:
                return await code.call(frame.thread, arguments)
            except ValueProblem as problem:
                raise self.error(f"{call.name}: {problem}", call.at) from None

        return Node(run, is_async=True)

    def _run_thread(self, expression: s.Run) -> Node:
        code = self._codes.find(self._scope, expression.name)
        assert code is not None  # checked

        def run(frame: CallFrame) -> Value:
            try:
                return frame.thread.execution.start_thread(code)
            except ValueProblem as problem:
                raise self.error(problem, expression.at) from None

        return Node(run, is_async=False)

    def _join(self, expression: s.Join) -> Node:
        handle = self.node(expression.handle)

        async def run(frame: CallFrame) -> Value:
            (thread,) = await evaluated([handle], frame)
            if isinstance(thread, Handle):
                return await frame.thread.timed(thread.end())
            if type(thread) is int:  # a thread variable before its first thread
                return None
            message = f"'join' waits for a thread, not for {described(thread)}"
            raise self.error(message, expression.at)

        return Node(run, is_async=True)


async def _remote(
    frame: CallFrame, server: RemoteServer, name: str, arguments: list[Value]
) -> Value:
    if name == CLOSE:
        server.close()
        return None
    answer = server.call(name, [sent(item) for item in arguments])
    return charged(frame, received(await frame.thread.timed(answer)))


def _inverted(value: Value) -> Value:
    return not boolean("not", value)


def _positions(call: s.Call, names: list[str]) -> list[int]:
    """Return the index of the parameter of each argument; the parameters must exist."""
    return [
        k if argument.name is None else names.index(argument.name)
        for k, argument in enumerate(call.arguments)
    ]
