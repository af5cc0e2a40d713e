"""A running program, with its threads, their timing and their termination.

Threads are tasks of one event loop. As on a real robot, a thread that computes
without pausing uses up its share of a control period and continues in the next period.
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
"""Maximum number of variables in the program and in all unfinished calls."""
MAX_DEPTH: Final = 100
"""Maximum depth of nested calls."""
SLICE: Final = 100
"""Number of statements that a thread executes before other threads can run."""
PER_PERIOD: Final = 500
"""Maximum number of statements that a program executes per control period. The
remaining statements are executed in the next period."""
MAX_UPDATES: Final = 20
"""Maximum number of updates to wait for a change. Another client may have reverted the
change."""
MAX_SPIN: Final = 1_000_000
"""Maximum number of statements that a thread executes without a statement that takes
time, such as sync()."""


class Runnable(Protocol):
    """A compiled program or thread."""

    @property
    def name(self) -> str: ...

    @property
    def at(self) -> Place: ...

    async def call(self, thread: Thread, arguments: Mapping[str, Value]) -> Value: ...


class Interpreting(Protocol):
    """The interpreter mode of a program."""

    # Any: the site of the call.
    async def run(self, site: Any, *, clear_queue: bool, clear_on_end: bool) -> None:
        """Execute statements in the scope of a call until ``end`` is called."""

    def end(self) -> None:
        """End ``run``."""

    async def clear(self) -> None:
        """Remove all definitions and variables of interpreted statements."""

    def close(self) -> None:
        """Reject the queued statements."""


@final
class Halted(Exception):  # noqa: N818 - ends a program, is not an error
    """Raised by the statement ``halt``."""


@final
class Thread:
    """A thread of a program; the first thread is the program itself."""

    def __init__(
        self, execution: Execution, name: str, *, is_main: bool = False
    ) -> None:
        self.execution = execution
        self.name = name
        self.is_main = is_main
        """Whether the thread is the program itself."""
        self.left = SLICE
        """Number of remaining statements before other threads can run."""
        self.depth = 0
        """Depth of nested calls."""
        self.pacer = Pacer(execution.box)
        """Pacer for the waits of this thread."""
        self._spun = 0

    @property
    def box(self) -> UrControlBox:
        """Control box on which the program runs."""
        return self.execution.box

    @property
    def moves(self) -> Moves:
        """Moves of the robot's arm."""
        return self.execution.moves

    async def give_way(self, at: Place) -> None:
        """Let other threads run after a number of statements."""
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
        """Wait for an action, and then until the thread may continue."""
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
        """Wait while the program is paused or the critical section is occupied."""
        await self.execution.gate()
        await self.execution.critical.wait(self)

    async def until_shown(self, condition: Callable[[], bool]) -> None:
        """Wait until an update contains the effect of a request."""
        for _ in range(MAX_UPDATES):
            if condition():
                return
            await self.box.next_update()

    async def moving(self, motion: Callable[[], Awaitable[None]]) -> None:
        """Execute a motion; only one thread at a time can move the arm.

        Raises:
            ValueProblem: If another thread is moving the robot, or the motion is
                impossible.
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
        """Prepare to run a program.

        Args:
            name: Name of the program's source, for error messages.
            box: The control box.
            moves: Moves of the control box's arm.
            is_secondary: Whether the program is secondary. A secondary program runs
                alongside the main program, even while the main program is paused.
        """
        self.name = name
        self.box = box
        self.moves = moves
        self.torques = Torques(box)
        self.sockets = Sockets(box)
        self.servers: set[RemoteServer] = set()
        """Servers with functions that the program can call."""
        self.watchdogs = Watchdogs(box, self._finish)
        self.history = ToolHistory(box)
        self._is_secondary = is_secondary
        self.waypoint: Pose | None = None
        """Target of the last move; None before the first move."""
        self.motion_version = 1
        """Version of movej and movel. In tool0, both versions are the same."""
        self.force_damping = 0.005
        """Damping of the next force mode that is started."""
        self.force_gain = 1.0
        """Gain scaling of the next force mode that is started."""
        self.globals: dict[str, Value] = {}
        self.critical = CriticalSection()
        self.mover: Thread | None = None
        """Thread that currently moves the robot."""
        self.interpreter: Interpreting
        """Interpreter of statements from clients, which is set before the program
        runs."""
        self._motion: asyncio.Task[None] | None = None
        """Current motion, which can be aborted."""
        self._tasks: dict[asyncio.Task[Value], Runnable] = {}
        self._end: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._variables = 0
        self._period = -1.0
        self._used = 0

    async def run(self, code: Runnable) -> None:
        """Run a program to its end, and then end its threads.

        Raises:
            URScriptError: If the program fails; the error contains the location.
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
        """Wait while the program is paused, unless the program is secondary."""
        if not self._is_secondary:
            await self.box.programs.gate()

    def add_variables(self, count: int) -> None:
        """Add the variables of a call; the count is negative at the end of the call.

        Raises:
            ValueProblem: If there are too many variables.
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
        """End the threads that were started from the given definitions."""
        tasks = {task for task, code in self._tasks.items() if code in codes}
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks)

    async def abortable(self, motion: Awaitable[None]) -> None:
        """Execute a motion until it ends or ``abort`` is called."""
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
        """Abort the current motion if there is one; the arm decelerates to rest."""
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
        except Exception as error:  # the caller of run reports the error
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
        """Count statements in this control period; wait if there are too many."""
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
            # A delayed process receives several periods together.
            periods = max(round(elapsed * self.box.rate), 1)
            self._used = max(self._used - PER_PERIOD * periods, 0)
