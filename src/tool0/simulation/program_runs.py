"""The running programs, which advance after each snapshot, between two ticks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar, final

from tool0.errors import ControlError
from tool0.protocol.goals import Goal
from tool0.protocol.programs import ENDED, ProgramRun
from tool0.protocol.state import Snapshot


class Execution(Protocol):
    """Executes one program.

    Any thread may use an ``Execution``, but only the thread of the tick may call
    ``look``.
    """

    goal: Goal
    """Goal that ends when the program ends."""

    @property
    def status(self) -> ProgramRun:
        """State of the program."""

    @property
    def is_stopping(self) -> bool:
        """Whether the program was stopped.

        A stopped program ends after its arm has been released.
        """

    def stop(self, reason: str) -> None:
        """End the program at the next snapshot."""

    def set_stepping(self, stepping: bool) -> None:
        """Set whether the program pauses before its next step."""

    def look(self, snapshot: Snapshot) -> None:
        """Advance the program.

        ``look`` is called between two ticks, in the thread of the tick.
        """


E = TypeVar("E", bound=Execution)


@final
class ProgramRuns:
    """The last program of each arm.

    Only the thread of the tick may call ``start`` and ``look``.
    """

    def __init__(self) -> None:
        self._last: dict[str, Execution] = {}
        self._active: tuple[Execution, ...] = ()
        self._count = 0

    @property
    def states(self) -> tuple[ProgramRun, ...]:
        """State of the last program of each arm that has run a program."""
        return tuple(run.status for run in tuple(self._last.values()))

    def start(self, arm: str, make: Callable[[int], E]) -> E:
        """Start the program that ``make`` creates for a program number.

        Raises:
            ControlError: If a program of ``arm`` is still running.
        """
        last = self._last.get(arm)
        if last is not None and last.status.state not in ENDED:
            what = "stops: let time pass"
            if not last.is_stopping:
                what = "still runs; stop it first"
            program = last.status.program
            raise ControlError(f"the program '{program}' of the arm '{arm}' {what}")
        self._count += 1
        made = make(self._count)
        self._last = {**self._last, arm: made}
        self._active = (*self._active, made)
        return made

    def is_ending(self, arm: str) -> bool:
        """Return whether the program of an arm was stopped but has not yet ended."""
        last = self._last.get(arm)
        return last is not None and last.status.state not in ENDED and last.is_stopping

    def find(self, arm: str | None) -> Execution:
        """Return the running program of an arm.

        If no arm is given, the only running program is returned.

        Raises:
            ControlError: If no program is running, or if several programs are running
                and no arm is given.
        """
        running = {run.status.arm: run for run in self._active}
        if arm is None and len(running) == 1:
            return next(iter(running.values()))
        if arm is None and running:
            names = ", ".join(running)
            raise ControlError(f"several programs run: say which arm's, of {names}")
        if arm not in running:
            where = "" if arm is None else f" on the arm '{arm}'"
            raise ControlError(f"no program runs{where}")
        return running[arm]

    def cancel(self, goal: Goal) -> bool:
        """Stop the program of a goal, and return whether the goal has a program."""
        run = next((run for run in self._last.values() if run.goal is goal), None)
        if run is not None:
            run.stop("it was stopped")
        return run is not None

    def stop_all(self, reason: str) -> None:
        """End every program at the next snapshot."""
        for run in self._active:
            run.stop(reason)

    def look(self, snapshot: Snapshot) -> None:
        """Advance every program after a snapshot."""
        for run in self._active:
            run.look(snapshot)
            if run.status.state in ENDED:
                self._active = tuple(item for item in self._active if item is not run)
