"""The journal: every request that changed the simulation, with its step.

Between two requests a simulation is deterministic.  A session can therefore be repeated
bit for bit from its start (``simulation/handlers/reproduction``) and its journal.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from itertools import islice
from typing import Final, final

from msgspec import Struct

from tool0.simulation.core import Core
from tool0.simulation.loop import Loop

MOST_REQUESTS: Final = 200_000
"""Number of requests that are kept: 400 s of a stream at 500 Hz."""
AT_ONCE: Final = 500
"""Largest number of requests read at once, so that the tick does not wait long."""
MOST_ITEMS: Final = 2_000_000
"""Number of trajectory points, path knots and similar items kept with the requests."""


class Executed(Struct, frozen=True, gc=False):
    """A request that changed the simulation, or failed to.

    Neither an entry nor a request is part of a reference cycle, so the garbage
    collector ignores them.  Otherwise, with a stream at 500 Hz, it would stop every
    thread for 0.1 s after a minute.
    """

    number: int
    """Number of the entry in the journal, from 0 on."""
    step: int
    """Ticks since the start; unlike ``tick``, not set back by a reset."""
    tick: int
    """Ticks since the start or the last reset, as in a snapshot."""
    time: float
    """Simulated time [s]."""
    request: Struct
    """Request that was carried out."""
    error: str | None
    """Error of the request; None if it succeeded."""
    n_items: int
    """Total length of the request's sequences."""


@final
class Journal:
    """Keeps requests in the order in which they ended.  Any thread may read them."""

    def __init__(self, core: Core, loop: Loop) -> None:
        """Start empty; ``loop`` controls the time of ``core``."""
        self._core, self._loop = core, loop
        self._lock = threading.Lock()
        self._entries: deque[Executed] = deque()
        self._n_items = 0
        self._count = 0

    def begin(self, request: Struct) -> Callable[[Exception | None], None]:
        """Note the time of a request; call the result with the request's outcome.

        Call both in the thread of the tick.
        """
        step, tick, time = self._loop.steps, self._core.ticks, self._core.time

        def end(error: Exception | None) -> None:
            why = None if error is None else str(error)
            n_items = _size(request)
            entry = Executed(self._count, step, tick, time, request, why, n_items)
            self._add(entry)

        return end

    def after(self, number: int = -1) -> tuple[Executed, ...]:
        """Return the entries after ``number``, oldest first; only the first of many."""
        with self._lock:
            first = self._count - len(self._entries)
            start = max(number + 1 - first, 0)
            found = islice(self._entries, start, start + AT_ONCE)
            return tuple(found)

    def _add(self, entry: Executed) -> None:
        with self._lock:
            self._count += 1
            self._entries.append(entry)
            self._n_items += entry.n_items
            while len(self._entries) > MOST_REQUESTS or (
                self._n_items > MOST_ITEMS and len(self._entries) > 1
            ):
                self._n_items -= self._entries.popleft().n_items


def _size(request: Struct) -> int:
    """Return the total length of a request's sequences."""
    values = (getattr(request, name) for name in request.__struct_fields__)
    return 1 + sum(len(value) for value in values if isinstance(value, tuple))
