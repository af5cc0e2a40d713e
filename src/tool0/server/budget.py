"""The processor time that all clients of a process may use together.

Each connection has an account, to which the work for that connection is charged.  While
all connections together use less than their share, or only one of them is active, none
has to wait.  Otherwise each may use an equal part, and a connection that has used more
waits: its messages are not read meanwhile, so that its socket slows it down.  A stop
never waits for its account.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, final

SHARE: Final = 0.3
"""Fraction of one processor that all clients together may use in the long run."""
BURST: Final = 0.5
"""Work of all clients together for which none has to wait [s]."""
RESERVE: Final = 0.01
"""Work of one client that never has to wait for other clients [s]."""
SLICE: Final = 0.3e-3
"""Work until the event loop polls its sockets again [s], since a stop may have
arrived."""
MAX_CHARGE: Final = 0.01
"""Largest charge for one piece of work [s], so that a long plan does not silence its
client."""
_ACTIVE: Final = 0.1
"""Time without any work after which a client leaves its part to others [wall s]."""
_LONGEST_WAIT: Final = 0.05
"""Longest time until a waiting account is checked again, since others may have left
meanwhile [wall s]."""
_SHORTEST_WAIT: Final = 1e-3
"""Shortest wait of an account [wall s]."""


@final
class Budget:
    """Processor time that all accounts of an event loop share."""

    def __init__(
        self,
        share: float = SHARE,
        burst: float = BURST,
        *,
        is_strict: bool = False,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """Start with a full burst.

        Args:
            share: Fraction of one processor for all clients together, in the long run.
            burst: Work of all clients together for which none has to wait [s].
            is_strict: Whether a client that is active alone has to wait, too.
            now: Function that returns the wall time [s].
        """
        self.share, self._burst, self.now = share, burst, now
        self._is_strict = is_strict
        self._left, self._counted_at = burst, now()
        self._active: dict[Account, float] = {}
        """Time at which each account was last charged."""
        self._slice_began_at: float | None = None
        """Processor time of the event loop's thread when it last polled its sockets
        [s]; None if no work was done since then."""
        self._turns: deque[asyncio.Future[None]] = deque()

    def account(self) -> Account:
        """Return the account of a new client."""
        return Account(self)

    @property
    def left(self) -> float:
        """Remaining work for which no client has to wait [s]; at most 0 if overused."""
        now = self.now()
        gained = (now - self._counted_at) * self.share
        self._left = min(self._burst, self._left + gained)
        self._counted_at = now
        return self._left

    @property
    def is_ample(self) -> bool:
        """Whether no client has to wait."""
        return self.left > 0.0 or (self.n_active <= 1 and not self._is_strict)

    @property
    def n_active(self) -> int:
        """Number of accounts that were charged recently."""
        oldest = self.now() - _ACTIVE
        # Sorted by these times, since a charged account moves to the end.
        while self._active:
            account, charged_at = next(iter(self._active.items()))
            if charged_at >= oldest:
                break
            del self._active[account]
        return len(self._active)

    @property
    def part(self) -> float:
        """Equal part of one processor for each active account."""
        return self.share / max(1, self.n_active)

    @property
    def is_slice_used(self) -> bool:
        """Whether the event loop must poll its sockets before further work."""
        start = self._slice_began_at
        return start is not None and time.thread_time() - start >= SLICE

    def charge(self, account: Account, seconds: float) -> None:
        """Charge work to an account."""
        self._left = max(self.left - seconds, -RESERVE)
        self._active.pop(account, None)
        self._active[account] = self._counted_at

    def begin_work(self) -> float:
        """Return the processor time of this thread, which is the event loop's [s]."""
        start = time.thread_time()
        if self._slice_began_at is None:
            self._slice_began_at = start
            asyncio.get_running_loop().call_soon(self._end_slice)
        return start

    async def turn(self) -> None:
        """Wait until the event loop has polled its sockets; one client at a time."""
        self.begin_work()
        turn = asyncio.get_running_loop().create_future()
        self._turns.append(turn)
        await turn

    def _end_slice(self) -> None:
        """Give the next client its turn after the event loop has polled its sockets."""
        self._slice_began_at = None
        while self._turns:
            turn = self._turns.popleft()
            if not turn.done():  # otherwise its connection has ended
                turn.set_result(None)
                self.begin_work()
                break


@final
class Account:
    """Processor time that one client has used."""

    def __init__(self, budget: Budget) -> None:
        self._budget = budget
        self._left, self._counted_at = RESERVE, budget.now()

    @property
    def may_go_on(self) -> bool:
        """Whether work for this client may begin at once."""
        return not self._budget.is_slice_used and self._delay() <= 0.0

    @property
    def has_spare(self) -> bool:
        """Whether all clients together use less than their share."""
        return self._budget.left > 0.0

    async def admit(self) -> None:
        """Wait until work for this client may begin."""
        while not self.may_go_on:
            if (delay := self._delay()) > 0.0:
                await asyncio.sleep(min(max(delay, _SHORTEST_WAIT), _LONGEST_WAIT))
            else:
                await self._budget.turn()

    async def pay(self, seconds: float) -> None:
        """Charge work for this client, and wait until more may begin."""
        self._budget.begin_work()
        self.charge(seconds)
        await self.admit()

    async def give_way(self) -> None:
        """Poll the event loop's sockets during long work, if it is time to."""
        self._budget.begin_work()
        if self._budget.is_slice_used:
            await self._budget.turn()

    def charge(self, seconds: float) -> None:
        """Charge work for this client."""
        seconds = min(seconds, MAX_CHARGE)
        self._left = max(self._own() - seconds, -MAX_CHARGE)
        self._budget.charge(self, seconds)

    @contextmanager
    def working(self) -> Iterator[None]:
        """Charge the work of this thread, the event loop's, to this client."""
        start = self._budget.begin_work()
        try:
            yield
        finally:
            self.charge(time.thread_time() - start)

    def _own(self) -> float:
        """Return the work that this client may do regardless of the others [s]."""
        now = self._budget.now()
        gained = (now - self._counted_at) * self._budget.part
        self._left = min(RESERVE, self._left + gained)
        self._counted_at = now
        return self._left

    def _delay(self) -> float:
        """Return the wall time until work for this client may begin [s]."""
        if self._budget.is_ample:
            return 0.0
        own = self._own()
        return 0.0 if own > 0.0 else -own / self._budget.part + _SHORTEST_WAIT
