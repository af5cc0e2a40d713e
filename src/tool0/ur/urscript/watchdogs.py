"""A program's watchdogs for RTDE inputs that a client must write repeatedly."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Final, Literal, TypeAlias, final

from tool0.errors import ControlError
from tool0.ur.waiting import within

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

Action: TypeAlias = Literal["ignore", "pause", "stop"]
ACTIONS: Final[tuple[Action, ...]] = ("ignore", "pause", "stop")


@final
class Watchdogs:
    """Reacts once to each input that is not written within its period [wall s]."""

    def __init__(self, box: UrControlBox, stop: Callable[[Exception], None]) -> None:
        """Create an empty set of watchdogs; ``stop`` ends the program with an error."""
        self._box = box
        self._stop = stop
        self._written: dict[str, asyncio.Event] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}

    def watch(self, name: str, period: float, action: Action) -> None:
        """Expect an input in each period [wall s]; replace its earlier watchdog."""
        if not self._tasks:
            self._box.registers.when_written.add(self._note)
        elif name in self._tasks:
            self._tasks[name].cancel()
        self._written[name] = asyncio.Event()
        self._tasks[name] = asyncio.create_task(self._watch(name, period, action))

    def close(self) -> None:
        """Stop all watchdogs."""
        self._box.registers.when_written.discard(self._note)
        for task in self._tasks.values():
            task.cancel()

    def _note(self, names: Collection[str]) -> None:
        for name in names:
            if name in self._written:
                self._written[name].set()

    async def _watch(self, name: str, period: float, action: Action) -> None:
        written = self._written[name]
        while await within(written.wait(), period):
            written.clear()
        error = ControlError(
            f"RTDE watchdog: '{name}' was not written for {period:g} s"
        )
        if action == "stop":
            self._stop(error)
        elif action == "pause" and not self._box.programs.is_paused:
            self._box.report(error)
            self._box.programs.pause()
