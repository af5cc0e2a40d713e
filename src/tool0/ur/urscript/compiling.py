"""Compiles statements to closures, and definitions to functions and threads."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NamedTuple, final

from tool0.ur.urscript import syntax as s
from tool0.ur.urscript.checking import Checker
from tool0.ur.urscript.code import (
    Body,
    CallFrame,
    Code,
    Interpreted,
    Jump,
    Node,
    Outcome,
    Returned,
    charged,
    evaluated,
    not_compiled,
)
from tool0.ur.urscript.execution import Halted
from tool0.ur.urscript.expressions import Expressions
from tool0.ur.urscript.parsing import parse
from tool0.ur.urscript.scopes import Scope
from tool0.ur.urscript.values import Handle, Value, described, truth, with_element
from tool0.ur.urscript_errors import Place, URScriptError, ValueProblem

INTERPRETER: Final = "interpreter"
"""Program name in error messages about statements that clients send."""


class CompiledStatement(NamedTuple):
    """A compiled statement."""

    # Any: an Outcome; with ``is_async``, an awaitable Outcome.
    run: Callable[[CallFrame], Any]
    is_async: bool
    at: Place


@final
class Compiler:
    """Compiles a checked program."""

    def __init__(self, program: str, codes: dict[int, Code] | None = None) -> None:
        self._program: Final = program
        self._codes = codes or {}

    def compile(self, scope: Scope) -> Code:
        """Compile a definition and the definitions inside it to closures."""
        code = self._declared(scope.definition)
        is_program = scope.parent is None
        code.n_variables = len(scope.globals if is_program else scope.locals)
        expressions = Expressions(self._program, scope, self)
        code.defaults = {
            item.name: expressions.node(item.default)
            for item in scope.definition.parameters
            if item.default is not None
        }
        statements = Statements(expressions, scope)
        code.body = statements.block(scope.definition.body)
        for definition in scope.functions.values():
            self.compile(scope.inner(definition))
        return code

    def extended(self) -> Compiler:
        """Return a copy of the compiler that keeps new definitions separate."""
        return Compiler(INTERPRETER, dict(self._codes))

    def interpreted(self, text: str, scope: Scope) -> Interpreted:
        """Compile statements in a scope while the program is running.

        Raises:
            URScriptError: If the statements are invalid.
        """
        block = parse(text, self._program)
        inner = scope.extended(block)
        Checker(self._program, has_servers=True).check_block(inner, block)
        called = _called(block)
        if "interpreter_mode" in called:
            raise URScriptError(
                "interpreter modes are not nested", block[0].at, self._program
            )
        known = set(self._codes.values())
        for item in block:
            if isinstance(item, s.Definition):
                self.compile(inner.inner(item))
        body = Statements(Expressions(self._program, inner, self), inner).block(block)
        own = set(self._codes.values()) - known
        return Interpreted(inner, body, own, "clear_interpreter" in called)

    def find(self, scope: Scope, name: str) -> Code | None:
        """Return the function or thread with a name that is visible in a scope."""
        found = scope.find(name)
        return None if found is None else self._declared(found[0])

    def _declared(self, definition: s.Definition) -> Code:
        key = id(definition)
        if key not in self._codes:
            self._codes[key] = Code(definition, 0, {}, not_compiled)
        return self._codes[key]


@final
class Statements:
    """Compiles the statements of a definition."""

    def __init__(self, expressions: Expressions, scope: Scope) -> None:
        self._expressions = expressions
        self._scope = scope

    def block(self, block: s.Block) -> Body:
        """Compile a block to a coroutine function."""
        steps = [self._step(x) for x in block if not isinstance(x, s.Definition)]

        async def run(frame: CallFrame) -> Outcome:
            thread = frame.thread
            for step, is_async, at in steps:
                thread.left -= 1
                if thread.left < 0:
                    await thread.give_way(at)
                outcome: Outcome = await step(frame) if is_async else step(frame)
                if outcome is not None:
                    return outcome
            return None

        return run

    def _step(self, statement: s.Statement) -> CompiledStatement:
        match statement:
            case s.Assign():
                call = self._scope.output_call(statement)
                return self._assign(statement) if call is None else self._step(call)
            case s.Evaluate(at=at, value=expression):
                return self._then(expression, at, lambda frame, value: None)
            case s.Return(at=at, value=returned):
                if returned is None:
                    return CompiledStatement(
                        lambda frame: Returned(None), is_async=False, at=at
                    )
                return self._then(returned, at, lambda frame, value: Returned(value))
            case s.Kill():
                return self._kill(statement)
            case s.If():
                return self._if(statement)
            case s.While():
                return self._while(statement)
            case s.Simple():
                return _simple(statement)
            case s.Definition():
                raise AssertionError(statement)

    def _then(
        self,
        expression: s.Expression,
        at: Place,
        finish: Callable[[CallFrame, Value], Outcome],
    ) -> CompiledStatement:
        """Return a statement that applies a function to the value of an expression."""
        node = self._expressions.node(expression)
        evaluate = node.run
        if not node.is_async:
            return CompiledStatement(
                lambda frame: finish(frame, evaluate(frame)), False, at
            )

        async def run(frame: CallFrame) -> Outcome:
            return finish(frame, await evaluate(frame))

        return CompiledStatement(run, is_async=True, at=at)

    def _assign(self, statement: s.Assign) -> CompiledStatement:
        name, at = statement.name, statement.at
        is_local = name in self._scope.locals and statement.scope != "global"
        if statement.indexes:
            return self._assign_element(statement)

        def store(frame: CallFrame, value: Value) -> None:
            if value is None:
                raise self._expressions.error("there is no value to assign", at)
            variables = frame.locals if is_local else frame.globals
            variables[name] = value

        return self._then(statement.value, at, store)

    def _assign_element(self, statement: s.Assign) -> CompiledStatement:
        name, at = statement.name, statement.at
        is_local = name in self._scope.locals
        nodes = [
            self._expressions.node(item)
            for item in (statement.value, *statement.indexes)
        ]

        async def run(frame: CallFrame) -> None:
            new, *indexes = await evaluated(nodes, frame)
            variables = frame.locals if is_local else frame.globals
            if name not in variables:
                message = f"variable '{name}' has no value yet"
                raise self._expressions.error(message, at)
            try:
                value = with_element(variables[name], indexes, new)
            except ValueProblem as problem:
                raise self._expressions.error(problem, at) from None
            variables[name] = charged(frame, value)

        return CompiledStatement(run, is_async=True, at=at)

    def _kill(self, statement: s.Kill) -> CompiledStatement:
        handle = self._expressions.node(statement.handle)

        async def run(frame: CallFrame) -> Outcome:
            (thread,) = await evaluated([handle], frame)
            if isinstance(thread, Handle):
                await thread.kill()
            elif type(thread) is not int:  # a thread variable before its first thread
                message = f"'kill' ends a thread, not {described(thread)}"
                raise self._expressions.error(message, statement.at)
            return None

        return CompiledStatement(run, is_async=True, at=statement.at)

    def _condition(self, expression: s.Expression) -> Node:
        node = self._expressions.node(expression)
        evaluate, at, error = node.run, expression.at, self._expressions.error

        def checked(value: Value) -> bool:
            if type(value) is bool:
                return value
            try:
                return truth(value)
            except ValueProblem as problem:
                raise error(problem, at) from None

        if not node.is_async:
            return Node(lambda frame: checked(evaluate(frame)), is_async=False)

        async def run(frame: CallFrame) -> bool:
            return checked(await evaluate(frame))

        return Node(run, is_async=True)

    def _if(self, statement: s.If) -> CompiledStatement:
        branches = [
            (*self._condition(condition), self.block(body))
            for condition, body in statement.branches
        ]
        otherwise = self.block(statement.otherwise)

        async def run(frame: CallFrame) -> Outcome:
            for condition, is_async, body in branches:
                holds = await condition(frame) if is_async else condition(frame)
                if holds:
                    return await body(frame)
            return await otherwise(frame)

        return CompiledStatement(run, is_async=True, at=statement.at)

    def _while(self, statement: s.While) -> CompiledStatement:
        condition, is_async = self._condition(statement.condition)
        body, at = self.block(statement.body), statement.at

        async def run(frame: CallFrame) -> Outcome:
            thread = frame.thread
            while await condition(frame) if is_async else condition(frame):
                thread.left -= 1
                if thread.left < 0:
                    await thread.give_way(at)
                outcome = await body(frame)
                if outcome is Jump.BREAK:
                    return None
                if isinstance(outcome, Returned):
                    return outcome
            return None

        return CompiledStatement(run, is_async=True, at=at)


def _called(block: s.Block) -> set[str]:
    """Return the names of the functions that a block's statements call directly."""
    values = [item.value for item in block if isinstance(item, s.Evaluate)]
    return {value.name for value in values if isinstance(value, s.Call)}


def _simple(statement: s.Simple) -> CompiledStatement:
    at = statement.at
    match statement.keyword:
        case "break":
            return CompiledStatement(lambda frame: Jump.BREAK, is_async=False, at=at)
        case "continue":
            return CompiledStatement(lambda frame: Jump.CONTINUE, is_async=False, at=at)
        case "halt":
            return CompiledStatement(_halt, is_async=False, at=at)
        case "pause":
            return CompiledStatement(_pause, is_async=True, at=at)
        case "enter_critical":
            return CompiledStatement(_enter_critical, is_async=True, at=at)
        case "exit_critical":
            return CompiledStatement(_exit_critical, is_async=False, at=at)
        case "pass":
            return CompiledStatement(lambda frame: None, is_async=False, at=at)


def _halt(frame: CallFrame) -> Outcome:
    raise Halted


async def _pause(frame: CallFrame) -> None:
    frame.thread.box.programs.pause()
    await frame.thread.hold()


async def _enter_critical(frame: CallFrame) -> None:
    await frame.thread.execution.critical.enter(frame.thread)


def _exit_critical(frame: CallFrame) -> None:
    frame.thread.execution.critical.leave(frame.thread)
