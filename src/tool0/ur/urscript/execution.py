"""A running program: its threads, their time, and how they end.

Threads are tasks of one event loop.  As on the robot, one that computes without end
uses up its share of a control period and goes on in the next one.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Collection, Mapping
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeVar, final

from tool0.ur.pacer import Pacer
from tool0.ur.tool_contact import ToolHistory
from tool0.ur.torques import Torques
from tool0.ur.urscript.critical import CriticalSection
from tool0.ur.urscript.remote import RemoteServer
from tool0.ur.urscript.sockets import Sockets
from tool0.ur.urscript.values import Handle, Pose, Value
from tool0.ur.urscript.watchdogs import Watchdogs
from tool0.ur.urscript_errors import Place, URScriptError, ValueProblem
from tool0.ur.waiting import seen

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox
    from tool0.ur.moves import Moves


T = TypeVar("T")

MAX_THREADS: Final = 50
MAX_VARIABLES: Final = 2_000
"""Largest number of variables of all unfinished calls, with those of the program."""
MAX_DEPTH: Final = 100
"""Largest depth of calls in calls."""
SLICE: Final = 100
"""Statements that a thread executes before others have their turn."""
PER_PERIOD: Final = 500
"""Statements of a program in one control period; the rest waits for the next one."""
MAX_UPDATES: Final = 20
"""Largest number of updates until a change is shown; another client may have changed it
back."""
MAX_SPIN: Final = 1_000_000
"""Statements of a thread without one that takes time, such as sync()."""


class Runnable(Protocol):
    """A program or a thread, compiled."""

    @property
    def name(self) -> str: ...

    @property
    def at(self) -> Place: ...

    async def call(self, thread: Thread, arguments: Mapping[str, Value]) -> Value: ...


class Interpreting(Protocol):
    """The interpreter mode."""

    # Any: the site of the call.
    async def run(self, site: Any, *, clear_queue: bool, clear_on_end: bool) -> None:
        """Execute statements in the scope of a call, until ``end`` is called."""

    def end(self) -> None:
        """End ``run``."""

    async def clear(self) -> None:
        """Forget what was interpreted."""

    def close(self) -> None:
        """Refuse what waits."""


@final
class Halted(Exception):  # noqa: N818 - the end of a program, not an error
    """The statement ``halt``."""


@final
class Thread:
    """One thread of a program; the program itself is the first."""

    def __init__(
        self, execution: Execution, name: str, *, is_main: bool = False
    ) -> None:
        self.execution = execution
        self.name = name
        self.is_main = is_main
        """Whether it is the program itself."""
        self.left = SLICE
        """Statements until others have their turn."""
        self.depth = 0
        """Depth of calls in calls."""
        self.pacer = Pacer(execution.box)
        """Pacer of the times that it waits."""
        self._spun = 0

    @property
    def box(self) -> UrControlBox:
        """The control box that the program runs on."""
        return self.execution.box

    @property
    def moves(self) -> Moves:
        """Moves of the robot."""
        return self.execution.moves

    async def give_way(self, at: Place) -> None:
        """Yield to other threads, after a number of statements."""
        used = SLICE - self.left
        self.left = SLICE
        self._spun += used
        if self._spun > MAX_SPIN:
            raise URScriptError(
                f"thread '{self.name}' executed {MAX_SPIN} statements without one that "
                "takes time; add sync() to its loop",
                at,
                self.execution.name,
            )
        await self.execution.share(used)
        await self.hold()

    async def timed(self, action: Awaitable[T]) -> T:
        """Wait for something that takes time, and for the permission to go on."""
        self._spun = 0
        critical = self.execution.critical
        was_inside = critical.is_inside(self)
        critical.leave(self)
        value = await action
        await self.execution.gate()
        if was_inside:
            await critical.resume(self)
        else:
            await critical.wait(self)
        return value

    async def hold(self) -> None:
        """Wait while the program is paused, or another thread is critical."""
        await self.execution.gate()
        await self.execution.critical.wait(self)

    async def until_shown(self, condition: Callable[[], bool]) -> None:
        """Wait until the updates show what a request has changed."""
        for _ in range(MAX_UPDATES):
            if condition():
                return
            await self.box.next_update()

    async def moving(self, motion: Callable[[], Awaitable[None]]) -> None:
        """Execute a motion, which one thread at a time can do.

        Raises:
            ValueProblem: Another thread is moving the robot, or it cannot move so.
        """
        execution = self.execution
        if execution.mover not in {None, self}:
            raise ValueProblem("another thread is controlling the robot already")
        execution.mover = self
        try:
            await motion()
        finally:
            execution.mover = None


@final
class Execution:
    """One run of a program."""

    def __init__(
        self,
        name: str,
        box: UrControlBox,
        moves: Moves,
        *,
        is_secondary: bool = False,
    ) -> None:
        """Prepare to run.

        Args:
            name: Name of the program's source, for messages.
            box: The control box.
            moves: Its arm's moves.
            is_secondary: Whether it runs beside the program, also while that is paused.
        """
        self.name = name
        self.box = box
        self.moves = moves
        self.torques = Torques(box)
        self.sockets = Sockets(box)
        self.servers: set[RemoteServer] = set()
        """Servers whose functions the program calls."""
        self.watchdogs = Watchdogs(box, self._finish)
        self.history = ToolHistory(box)
        self._is_secondary = is_secondary
        self.waypoint: Pose | None = None
        """Target of the last move."""
        self.motion_version = 1
        """Version of movej and movel; both are the same here."""
        self.force_damping = 0.005
        """Damping of the next force mode."""
        self.force_gain = 1.0
        """Scales the gain of the next force mode."""
        self.globals: dict[str, Value] = {}
        self.critical = CriticalSection()
        self.mover: Thread | None = None
        """The thread that moves the robot."""
        self.interpreter: Interpreting
        """Interpreter of statements that clients send; set before it runs."""
        self._motion: asyncio.Task[None] | None = None
        """The move that can be aborted."""
        self._tasks: dict[asyncio.Task[Value], Runnable] = {}
        self._end: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._variables = 0
        self._period = -1.0
        self._used = 0

    async def run(self, code: Runnable) -> None:
        """Run a program to its end, and end its threads.

        Raises:
            URScriptError: The program failed, with the location.
        """
        with self.history:
            main = self._start(code, is_main=True)
            main.add_done_callback(lambda _: self._finish(None))
            try:
                await self._end
            finally:
                for task in self._tasks:
                    task.cancel()
                if self._tasks:
                    await asyncio.wait(set(self._tasks))
                self.watchdogs.close()
                self.interpreter.close()
                self.sockets.close_all()
                for server in tuple(self.servers):
                    server.close()

    async def gate(self) -> None:
        """Wait while the program is paused."""
        if not self._is_secondary:
            await self.box.programs.gate()

    def add_variables(self, count: int) -> None:
        """Count the variables of a call, or those of one that has ended.

        Raises:
            ValueProblem: There are too many.
        """
        self._variables += count
        if count > 0 and self._variables > MAX_VARIABLES:
            self._variables -= count
            raise ValueProblem(f"the program has more than {MAX_VARIABLES} variables")

    def start_thread(self, code: Runnable) -> Handle:
        """Start a thread of the program."""
        if len(self._tasks) >= MAX_THREADS:
            raise ValueProblem(f"more than {MAX_THREADS} threads run")
        return Handle(code.name, self._start(code))

    async def end_threads(self, codes: Collection[object]) -> None:
        """End the threads that were started of these definitions."""
        tasks = {task for task, code in self._tasks.items() if code in codes}
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks)

    async def abortable(self, motion: Awaitable[None]) -> None:
        """Execute a motion until its end, or until ``abort`` is called."""
        self._motion = task = asyncio.ensure_future(motion)
        task.add_done_callback(seen)
        try:
            await asyncio.wait({task})
        finally:
            self._motion = None
            if not task.done():
                task.cancel()
                await asyncio.wait({task})
        if not task.cancelled():
            task.result()

    def abort(self) -> None:
        """End the move that can be aborted, if there is one: the arm slows down."""
        if self._motion is not None:
            self._motion.cancel()

    def _start(self, code: Runnable, *, is_main: bool = False) -> asyncio.Task[Value]:
        task = asyncio.get_running_loop().create_task(self._run(code, is_main=is_main))
        self._tasks[task] = code
        task.add_done_callback(self._tasks.pop)
        return task

    async def _run(self, code: Runnable, *, is_main: bool) -> Value:
        thread = Thread(self, code.name, is_main=is_main)
        try:
            return await code.call(thread, {})
        except Halted:
            self._finish(None)
        except ValueProblem as problem:
            self._finish(URScriptError(str(problem), code.at, self.name))
        except RecursionError:
            message = "calls, blocks and expressions are nested too deep"
            self._finish(URScriptError(message, code.at, self.name))
        except Exception as error:  # whoever runs the program reports it
            self._finish(error)
        finally:
            self.critical.leave(thread)
        return None

    def _finish(self, error: Exception | None) -> None:
        if self._end.done():
            return
        if error is None:
            self._end.set_result(None)
        else:
            self._end.set_exception(error)

    async def share(self, statements: int) -> None:
        """Count statements of this control period; wait when there were too many."""
        self._look_at_time()
        self._used += statements
        if self._used < PER_PERIOD:
            await asyncio.sleep(0)
        while self._used >= PER_PERIOD:
            await self.box.next_update()
            self._look_at_time()

    def _look_at_time(self) -> None:
        elapsed, self._period = self.box.time - self._period, self.box.time
        if elapsed:
            # A process that was late sees several periods at once.
            periods = max(round(elapsed * self.box.rate), 1)
            self._used = max(self._used - PER_PERIOD * periods, 0)
