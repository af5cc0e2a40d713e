"""Compiled programs, which are closures that run on a frame of variables."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final, NamedTuple, Protocol, TypeAlias, final

from tool0.ur.urscript import syntax as s
from tool0.ur.urscript.execution import MAX_DEPTH, Thread
from tool0.ur.urscript.scopes import Scope
from tool0.ur.urscript.values import Value, weight
from tool0.ur.urscript_errors import Place, ValueProblem

_LONG: Final = 5
"""Length of a list above which the work on it is charged as statements."""
_PER_STATEMENT: Final = 10
"""Number of list elements that are charged as one statement."""


@final
@dataclass(slots=True)
class CallFrame:
    """The variables that a call of a function can access."""

    thread: Thread
    globals: dict[str, Value]
    locals: dict[str, Value]


# Any: a Value; with ``is_async``, an awaitable Value.
Run: TypeAlias = Callable[[CallFrame], Any]
Combine: TypeAlias = Callable[[CallFrame, list[Value]], Value]


class Node(NamedTuple):
    """A compiled expression."""

    run: Run
    is_async: bool


def combined(nodes: Sequence[Node], combine: Combine) -> Node:
    """Return a node that evaluates other nodes in order and combines their values."""
    runs = [node.run for node in nodes]
    if not any(node.is_async for node in nodes):

        def run(frame: CallFrame) -> Value:
            return combine(frame, [each(frame) for each in runs])

        return Node(run, is_async=False)

    async def run_async(frame: CallFrame) -> Value:
        return combine(frame, await evaluated(nodes, frame))

    return Node(run_async, is_async=True)


def charged(frame: CallFrame, value: Value) -> Value:
    """Return a value; the work of making a long list is charged as statements."""
    if type(value) is tuple and len(value) > _LONG:
        frame.thread.left -= weight(value) // _PER_STATEMENT
    return value


async def evaluated(nodes: Sequence[Node], frame: CallFrame) -> list[Value]:
    """Evaluate nodes in order and return their values."""
    return [
        await node.run(frame) if node.is_async else node.run(frame) for node in nodes
    ]


class Jump(Enum):
    """Kind of a statement that jumps within a loop."""

    BREAK = "break"
    CONTINUE = "continue"


@final
class Returned(NamedTuple):
    """Result of a ``return`` statement."""

    value: Value


Outcome: TypeAlias = Jump | Returned | None
Body: TypeAlias = Callable[[CallFrame], Awaitable[Outcome]]


@final
@dataclass(slots=True, eq=False)
class Code:
    """A compiled function, thread or program."""

    definition: s.Definition
    n_variables: int
    """Number of local variables; for a program, the number of global variables."""
    defaults: dict[str, Node]
    body: Body

    @property
    def name(self) -> str:
        """Name of the definition."""
        return self.definition.name

    @property
    def at(self) -> Place:
        """Location of the definition."""
        return self.definition.at

    async def call(self, thread: Thread, arguments: Mapping[str, Value]) -> Value:
        """Execute the code and return its value."""
        if thread.depth >= MAX_DEPTH:
            raise ValueProblem(f"calls are nested deeper than {MAX_DEPTH} levels")
        execution = thread.execution
        execution.add_variables(self.n_variables)
        frame = CallFrame(thread, execution.globals, dict(arguments))
        thread.depth += 1
        try:
            for name, node in self.defaults.items():
                if name not in arguments:
                    (frame.locals[name],) = await evaluated([node], frame)
            outcome = await self.body(frame)
        finally:
            thread.depth -= 1
            execution.add_variables(-self.n_variables)
        return outcome.value if isinstance(outcome, Returned) else None


async def not_compiled(frame: CallFrame) -> Outcome:
    """Raise an error; placeholder for a body that has not been compiled yet."""
    raise AssertionError(frame)


class Interpreted(NamedTuple):
    """Statements that were compiled while the program was running."""

    scope: Scope
    """Scope for the statements that follow."""
    body: Body
    own: set[Code]
    """Functions and threads that the statements define."""
    clears: bool
    """Whether a statement calls clear_interpreter."""


class Codes(Protocol):
    """Compiled functions and threads."""

    def find(self, scope: Scope, name: str) -> Code | None:
        """Return the function or thread with a name that is visible in a scope."""

    def extended(self) -> Codes:
        """Return a copy to which code can be added without changing the original."""

    def interpreted(self, text: str, scope: Scope) -> Interpreted:
        """Compile statements in a scope; raise URScriptError if they are invalid."""


@final
class Site(NamedTuple):
    """Location from which a function is called."""

    frame: CallFrame
    scope: Scope
    codes: Codes
