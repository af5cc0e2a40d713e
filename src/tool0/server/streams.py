"""Streams of setpoints from connections, and of snapshots and events to them."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Collection
from dataclasses import dataclass
from typing import Any, Final, final

import msgspec

from tool0.protocol.backend import States
from tool0.protocol.bus import (
    Faulted,
    GoalFinished,
    Overran,
    Reported,
    Subscription,
    WasFrozen,
    WasReset,
)
from tool0.protocol.codec import (
    EventMessage,
    Fault,
    GoalEnded,
    LateTicks,
    ResetDone,
    encode,
    outcome_of,
    snapshot_message,
)
from tool0.protocol.state import Snapshot
from tool0.server.session import Session

logger = logging.getLogger(__name__)

INTERVAL: Final = 0.1
"""Shortest time between two setpoints of one stream that are carried out [wall s]."""


@final
@dataclass(frozen=True, slots=True)
class StreamedSetpoint:
    """The newest setpoint of a stream, and who sent it."""

    sender: object
    request: Any
    """A request with ``positions``."""


@final
class SetpointStreams:
    """Keeps the newest setpoint of each stream until it is due.

    Only the newest of many slider events is executed.  The last one always is, even if
    its sender has disconnected.
    """

    def __init__(
        self, carry_out: Callable[[StreamedSetpoint], Awaitable[None]]
    ) -> None:
        self._carry_out = carry_out
        self._waiting: dict[str, StreamedSetpoint] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._locks: dict[str, asyncio.Lock] = {}

    def submit(self, setpoint: StreamedSetpoint) -> None:
        """Replace the waiting setpoint by ``setpoint``.

        Joints named only in the older one of the same sender keep its positions.
        """
        key = getattr(setpoint.request, "controller", "")
        before = self._waiting.get(key)
        if before is not None and before.sender is setpoint.sender:
            positions = {**before.request.positions, **setpoint.request.positions}
            request = msgspec.structs.replace(setpoint.request, positions=positions)
            setpoint = StreamedSetpoint(setpoint.sender, request)
        self._waiting[key] = setpoint
        if key not in self._tasks:
            self._tasks[key] = asyncio.create_task(self._run(key))

    def drop(self, keys: Collection[str]) -> None:
        """Drop the waiting setpoint: a newer request supersedes it."""
        for key in keys:
            self._waiting.pop(key, None)

    async def settle(self, keys: Collection[str]) -> None:
        """Drop the waiting setpoints, and wait for those in progress."""
        self.drop(keys)
        for key in keys:
            if key in self._locks:
                async with self._locks[key]:
                    pass

    def drop_all(self) -> None:
        """Drop every waiting setpoint."""
        self._waiting.clear()

    def close(self) -> None:
        """Drop everything."""
        self.drop_all()
        for task in self._tasks.values():
            task.cancel()

    async def _run(self, key: str) -> None:
        lock = self._locks.setdefault(key, asyncio.Lock())
        loop = asyncio.get_running_loop()
        try:
            while key in self._waiting:
                start = loop.time()
                async with lock:
                    setpoint = self._waiting.pop(key, None)  # settled meanwhile
                    if setpoint is not None:
                        await self._carry_out(setpoint)
                await asyncio.sleep(start + INTERVAL - loop.time())
        finally:
            del self._tasks[key]


POLL_PERIOD: Final = 0.004
"""[wall s]: twice the shortest snapshot period; nothing is missed in between."""


@final
class _RateStream:
    """One rate's subscription and its sessions."""

    def __init__(self, subscription: Subscription, rate: float) -> None:
        self.subscription = subscription
        self.period = 1.0 / rate
        self.sessions: dict[Session, bool] = {}
        """Whether each has received a complete snapshot."""
        self.last: Snapshot | None = None

    def send(self, snapshot: Snapshot) -> None:
        """Queue a snapshot for every session, if it is due at this rate."""
        before = self.last
        if before and 0.0 <= snapshot.time - before.time < self.period - 1e-6:
            return
        self.last = snapshot
        changes = encode(snapshot_message(snapshot, before))
        for session, is_complete in self.sessions.items():
            if session.missed or not is_complete:
                missed, session.missed = session.missed, 0
                text = encode(snapshot_message(snapshot, None, missed))
                self.sessions[session] = True
                session.send_snapshot(text)
            else:
                session.send_snapshot(changes)


@final
class SnapshotStreams:
    """Sends snapshots and events to subscribed sessions, in the event loop.

    The bus is polled in the server's thread, so that the cost in the tick does not
    depend on the number of subscribers.  A snapshot is encoded once for all of a rate.
    """

    def __init__(self, states: States) -> None:
        self._states = states
        self._streams: dict[float, _RateStream] = {}
        self._task: asyncio.Task[None] | None = None

    async def add(self, session: Session, rate: float) -> None:
        """Let ``session`` receive ``rate`` snapshots per simulated second [Hz]."""
        if rate not in self._streams:
            subscription = await asyncio.to_thread(self._states.subscribe, rate)
            subscription.pending()  # the stream starts with the next one
            stream = _RateStream(subscription, rate)
            if self._streams.setdefault(rate, stream) is not stream:
                _close_in_background(stream)
        self._streams[rate].sessions[session] = False
        if self._task is None:
            self._task = asyncio.create_task(self._poll())

    def remove(self, session: Session) -> None:
        """Stop sending to ``session``."""
        for rate, stream in list(self._streams.items()):
            if stream.sessions.pop(session, None) is not None and not stream.sessions:
                del self._streams[rate]
                _close_in_background(stream)

    def close(self) -> None:
        """End every stream."""
        if self._task is not None:
            self._task.cancel()
        for stream in self._streams.values():
            _close_in_background(stream)
        self._streams.clear()

    async def _poll(self) -> None:
        while self._streams:
            for stream in list(self._streams.values()):
                try:
                    self._send_new(stream)
                except Exception:  # one failure must not end all streams
                    logger.exception("a snapshot could not be sent")
            await asyncio.sleep(POLL_PERIOD)
        self._task = None

    def _send_new(self, stream: _RateStream) -> None:
        for snapshot in stream.subscription.pending():
            stream.send(snapshot)
        events = stream.subscription.events
        while events:
            event = events.popleft()
            if isinstance(event, Reported | WasFrozen):
                continue  # for the panel and the log
            text = encode(event_message(self._states, event))
            for session in stream.sessions:
                session.send(text)


def _close_in_background(stream: _RateStream) -> None:
    """Close a subscription in a separate thread: it waits for the tick."""
    close = stream.subscription.close
    asyncio.get_running_loop().run_in_executor(None, close)


def event_message(
    states: States, event: GoalFinished | Faulted | Overran | WasReset
) -> EventMessage:
    """Return an event as it is sent."""
    match event:
        case GoalFinished(goal):
            assert goal.result is not None  # it has finished
            return GoalEnded(
                goal=states.goals.number(goal),
                controller=goal.controller,
                outcome=outcome_of(goal.result),
            )
        case Faulted(message, time):
            return Fault(message=message, time=time)
        case Overran(count, time):
            return LateTicks(count=count, time=time)
        case WasReset(time):
            return ResetDone(time=time)
