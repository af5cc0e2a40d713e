"""Limit of the processor time that all clients of a process use together.

Each connection has an account, to which the work for this connection is charged.  No
connection has to wait while all connections together use less than their share, or only
one connection is active.  Otherwise, each connection may use an equal part of the
share.  A connection that has used more than its part has to wait.  The messages of a
waiting connection are not read, so the flow control of its socket slows down the
client.  A stop request never has to wait for the account of its connection.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, final

SHARE: Final = 0.3
"""Fraction of one processor that all clients together may use on average."""
BURST: Final = 0.5
"""Processor time that all clients together may use without waiting [s]."""
RESERVE: Final = 0.01
"""Processor time that one client may use without waiting for other clients [s]."""
SLICE: Final = 0.3e-3
"""Processor time after which the event loop polls its sockets again [s], because a stop
request may have been received."""
MAX_CHARGE: Final = 0.01
"""Largest charge for one piece of work [s].  The limit prevents a long planning request
from blocking its client."""
_ACTIVE: Final = 0.1
"""Time without work after which a client is inactive, and active clients share its part
[wall s]."""
_LONGEST_WAIT: Final = 0.05
"""Longest time until a waiting account is checked again, because other clients may have
become inactive [wall s]."""
_SHORTEST_WAIT: Final = 1e-3
"""Shortest time for which an account waits [wall s]."""


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
        """Initialize the budget with the processor time of a full burst.

        Args:
            share: Fraction of one processor that all clients together may use on
                average.
            burst: Processor time that all clients together may use without waiting [s].
            is_strict: Whether a client also has to wait if it is the only active
                client.
            now: Function that returns the wall time [s].
        """
        self.share, self._burst, self.now = share, burst, now
        self._is_strict = is_strict
        self._left, self._counted_at = burst, now()
        self._active: dict[Account, float] = {}
        """Wall time at which each account was last charged [s]."""
        self._slice_began_at: float | None = None
        """Processor time of the event loop's thread at the last poll of its sockets
        [s]; None if no work has been done since the poll."""
        self._turns: deque[asyncio.Future[None]] = deque()

    def account(self) -> Account:
        """Return the account of a new client."""
        return Account(self)

    @property
    def left(self) -> float:
        """Processor time that clients may use without waiting [s]; may be negative."""
        now = self.now()
        gained = (now - self._counted_at) * self.share
        self._left = min(self._burst, self._left + gained)
        self._counted_at = now
        return self._left

    @property
    def is_ample(self) -> bool:
        """Whether all clients may work without waiting."""
        return self.left > 0.0 or (self.n_active <= 1 and not self._is_strict)

    @property
    def n_active(self) -> int:
        """Number of accounts that were charged recently."""
        oldest = self.now() - _ACTIVE
        # The accounts are sorted by the times of their last charges, because a charged
        # account is moved to the end.
        while self._active:
            account, charged_at = next(iter(self._active.items()))
            if charged_at >= oldest:
                break
            del self._active[account]
        return len(self._active)

    @property
    def part(self) -> float:
        """The equal part of one processor for each active account, as a fraction."""
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
        """Begin work in the event loop and return its thread's processor time [s]."""
        start = time.thread_time()
        if self._slice_began_at is None:
            self._slice_began_at = start
            asyncio.get_running_loop().call_soon(self._end_slice)
        return start

    async def turn(self) -> None:
        """Wait for the next turn, which begins after the event loop polls sockets."""
        self.begin_work()
        turn = asyncio.get_running_loop().create_future()
        self._turns.append(turn)
        await turn

    def _end_slice(self) -> None:
        """Start the next client's turn after the event loop has polled its sockets."""
        self._slice_began_at = None
        while self._turns:
            turn = self._turns.popleft()
            if not turn.done():  # the connection has not ended
                turn.set_result(None)
                self.begin_work()
                break


@final
class Account:
    """Account of the processor time that one client has used."""

    def __init__(self, budget: Budget) -> None:
        self._budget = budget
        self._left, self._counted_at = RESERVE, budget.now()

    @property
    def may_go_on(self) -> bool:
        """Whether work for this client may begin immediately."""
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
        """Charge work for this client, and wait until more work may begin."""
        self._budget.begin_work()
        self.charge(seconds)
        await self.admit()

    async def give_way(self) -> None:
        """Poll the event loop's sockets during long work if the slice is used up."""
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
        """Charge the work of this thread, which runs the event loop, to this client."""
        start = self._budget.begin_work()
        try:
            yield
        finally:
            self.charge(time.thread_time() - start)

    def _own(self) -> float:
        """Return the processor time that this client is guaranteed [s]."""
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
