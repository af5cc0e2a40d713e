"""The journal, which records every request that changed the simulation.

Each request is recorded with its step.  Between two requests, a simulation is
deterministic.  The data of a session's start (``simulation/handlers/reproduction``) and
the session's journal are therefore sufficient for an exact repetition of the session.
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
"""Largest number of requests that are stored; this corresponds to 400 s of a stream at
500 Hz."""
AT_ONCE: Final = 500
"""Largest number of requests that are returned by one read, so that the tick is not
blocked for long."""
MOST_ITEMS: Final = 2_000_000
"""Largest number of trajectory points, path knots and similar items that are stored
with the requests."""


class Executed(Struct, frozen=True, gc=False):
    """A request that changed the simulation or failed to change it.

    Entries and requests are never part of a reference cycle, so they are excluded from
    garbage collection.  If entries were not excluded, the garbage collector would stop
    every thread for 0.1 s after one minute of a stream at 500 Hz.
    """

    number: int
    """Number of the entry in the journal, starting at 0."""
    step: int
    """Number of ticks since the start; a reset does not set this number to 0."""
    tick: int
    """Number of ticks since the start or the last reset, as in a snapshot."""
    time: float
    """Simulated time [s]."""
    request: Struct
    """Request that was executed."""
    error: str | None
    """Error of the request; None if the request succeeded."""
    n_items: int
    """Size of the request: 1 plus the total length of the request's sequences."""


@final
class Journal:
    """Stores requests in the order in which they were completed.

    Any thread may read the requests.
    """

    def __init__(self, core: Core, loop: Loop) -> None:
        """Create an empty journal; ``loop`` controls the time of ``core``."""
        self._core, self._loop = core, loop
        self._lock = threading.Lock()
        self._entries: deque[Executed] = deque()
        self._n_items = 0
        self._count = 0

    def begin(self, request: Struct) -> Callable[[Exception | None], None]:
        """Record the time of a request, and return a function that reports its end.

        Call the returned function with the error of the request, or with None if the
        request succeeded.

        ``begin`` and the returned function must be called in the thread of the tick.
        """
        step, tick, time = self._loop.steps, self._core.ticks, self._core.time

        def end(error: Exception | None) -> None:
            why = None if error is None else str(error)
            n_items = _size(request)
            entry = Executed(self._count, step, tick, time, request, why, n_items)
            self._add(entry)

        return end

    def after(self, number: int = -1) -> tuple[Executed, ...]:
        """Return the entries with numbers above ``number``, in order.

        The result contains at most ``AT_ONCE`` entries.
        """
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
    """Return 1 plus the total length of a request's sequences."""
    values = (getattr(request, name) for name in request.__struct_fields__)
    return 1 + sum(len(value) for value in values if isinstance(value, tuple))
