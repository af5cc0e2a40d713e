"""The interpreter mode, in which clients add statements to a running program.

Source: URScript manual 5.x, "Interpreter Mode". A statement is compiled in the scope of
the ``interpreter_mode`` call, acknowledged, and executed after the previous statements.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias, final

from tool0.ur.urscript_errors import URScriptError, ValueProblem

if TYPE_CHECKING:
    from tool0.ur.urscript.code import Body, CallFrame, Code, Codes, Site
    from tool0.ur.urscript.execution import Execution
    from tool0.ur.urscript.scopes import Scope

MAX_QUEUE: Final = 1000
"""Maximum number of statements that wait to be interpreted or executed."""
NOT_RUNNING: Final = "no program is running"
STATES: Final = (
    *("statelastexecuted", "statelastinterpreted", "statelastcleared"),
    "stateunexecuted",
)
"""Commands that query a number; the number is 0 if no program is running."""
_CLEANED: Final = "cleared when the interpreter mode began"

Reply: TypeAlias = Callable[[str], None]


class _Received(NamedTuple):
    text: str
    reply: Reply


class _Ready(NamedTuple):
    number: int
    body: Body
    clears: bool
    """Whether the statement calls clear_interpreter."""


def discarded(reason: str, text: str) -> str:
    """Return the reply to a statement that is rejected."""
    return f"discard: {reason}: {text}"


@final
@dataclass(slots=True, eq=False)
class _Session:
    """Statements that were interpreted in a scope since the scope was last cleared."""

    site: Site
    codes: Codes
    scope: Scope
    own: set[Code] = field(default_factory=set)
    """Functions and threads that the statements defined."""


@final
class Interpreter:
    """Executes the statements that clients send to a program."""

    def __init__(self, execution: Execution) -> None:
        self._execution = execution
        self._received: deque[_Received] = deque()
        self._ready: deque[_Ready] = deque()
        self._arrived = asyncio.Event()
        self._is_ready = asyncio.Event()
        self._session: _Session | None = None
        self._kept: dict[int, _Session] = {}
        """Sessions of calls with clearOnEnd = False. The key identifies the definition
        that contains the call."""
        self._ends = False
        self._is_clearing = False
        self._interpreted = self._executed = self._cleared = 0

    # ---- the client's side ----------------------------------------------------------

    def submit(self, text: str, reply: Reply) -> None:
        """Accept a line from a client; reply immediately or after interpreting it."""
        match text:
            case "skipbuffer":
                self._ready.clear()
                self._arrived.set()
            case "abort":
                self._execution.abort()
            case "statelastexecuted":
                reply(f"state: {self._executed}: {text}")
                return
            case "statelastinterpreted":
                reply(f"state: {self._interpreted}: {text}")
                return
            case "statelastcleared":
                reply(f"state: {self._cleared}: {text}")
                return
            case "stateunexecuted":
                reply(f"state: {len(self._ready)}: {text}")
                return
            case _:
                if len(self._received) + len(self._ready) >= MAX_QUEUE:
                    reply(discarded(f"more than {MAX_QUEUE} statements wait", text))
                    return
                self._received.append(_Received(text, reply))
                self._arrived.set()
                return
        reply(f"ack: {self._interpreted}: {text}")

    def close(self) -> None:
        """Reject the queued statements, because the program has ended."""
        self._discard(NOT_RUNNING)

    def _discard(self, reason: str) -> None:
        for text, reply in self._received:
            reply(discarded(reason, text))
        self._received.clear()

    # ---- the program's side ---------------------------------------------------------

    async def run(self, site: Site, *, clear_queue: bool, clear_on_end: bool) -> None:
        """Execute statements in the scope of a call until ``end`` is called.

        Raises:
            ValueProblem: If the caller is not the main thread, or the mode is already
                active.
        """
        thread = site.frame.thread
        if not thread.is_main:
            raise ValueProblem("it is called in the main thread only")
        if self._session is not None:
            raise ValueProblem("the program is in the interpreter mode already")
        key = id(site.scope.definition)
        session = self._kept.pop(key, None)
        if session is None:
            session = _Session(site, site.codes.extended(), site.scope)
        session.site = site
        if clear_queue:
            self._discard(_CLEANED)
        self._session, self._ends = session, False
        interpreting = asyncio.create_task(self._interpret(session))
        try:
            while not self._ends:
                await self._execute_next(site.frame)
        finally:
            interpreting.cancel()
            await asyncio.wait([interpreting])
            self._session = None
            self._ready.clear()
        if clear_on_end:
            await self._forget(session)
            self._cleared = self._interpreted
        else:
            self._kept[key] = session

    def end(self) -> None:
        """End the interpreter mode after the current statement."""
        self._ends = True
        self._is_ready.set()

    async def clear(self) -> None:
        """Remove all definitions and variables of interpreted statements.

        Raises:
            ValueProblem: If the program is not in the interpreter mode.
        """
        session = self._session
        if session is None:
            raise ValueProblem("the program is not in the interpreter mode")
        await self._forget(session)
        self._cleared = self._executed

    async def _forget(self, session: _Session) -> None:
        """Remove a session's functions and variables, and end its threads."""
        await self._execution.end_threads(session.own)
        site, scope = session.site, session.scope
        for names, variables in (
            (scope.globals - site.scope.globals, self._execution.globals),
            (scope.locals - site.scope.locals, site.frame.locals),
        ):
            for name in names:
                variables.pop(name, None)
        session.codes, session.scope = site.codes.extended(), site.scope
        session.own.clear()

    async def _execute_next(self, frame: CallFrame) -> None:
        thread = frame.thread
        if not self._ready:
            self._is_ready.clear()
            await thread.timed(self._is_ready.wait())
        if self._ends or not self._ready:
            return
        statement = self._ready.popleft()
        self._executed = statement.number
        self._is_clearing = statement.clears
        try:
            await statement.body(frame)
        finally:
            self._is_clearing = False
        self._arrived.set()

    async def _interpret(self, session: _Session) -> None:
        """Compile received statements, except while a clear is queued."""
        while True:
            is_clearing = self._is_clearing or any(item.clears for item in self._ready)
            if is_clearing or not self._received:
                self._arrived.clear()
                await self._arrived.wait()
                continue
            text, reply = self._received[0]
            try:
                found = await asyncio.to_thread(
                    session.codes.interpreted, text, session.scope
                )
            except URScriptError as error:
                place = f"line {error.line}, column {error.column}"
                answer = discarded(f"{error.message} ({place})", text)
            else:
                session.scope = found.scope
                session.own |= found.own
                self._interpreted += 1
                self._ready.append(_Ready(self._interpreted, found.body, found.clears))
                self._is_ready.set()
                answer = f"ack: {self._interpreted}: {text}"
            self._received.popleft()
            reply(answer)
