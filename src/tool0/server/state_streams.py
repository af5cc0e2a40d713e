"""Streams of states, events and the log to connections."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple, final

from tool0.errors import ControlError, did_you_mean
from tool0.protocol.backend import States
from tool0.protocol.bus import (
    Event,
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
)
from tool0.protocol.state import SNAPSHOT_PERIOD, Snapshot
from tool0.protocol.state_message import StateMask, state_message
from tool0.protocol.subscriptions import LogMessage, Subscribe
from tool0.server.session import Session

logger = logging.getLogger(__name__)

POLL_PERIOD: Final = 0.004
"""Period of polling for states [wall s], which is twice the shortest snapshot period.
No state is lost between two polls."""
_FLUSH_PERIOD: Final = 0.05
"""Wall time after which a delayed state is sent in any case [s]."""
_FAST_PERIOD: Final = 0.02
"""Wall time between states while simulated time runs fast [s].  Each state delays the
tick by about 0.4 ms, because the stream and the tick both need the interpreter's
lock."""
_COMPANION_LOGGERS: Final = ("tool0.ros2", "tool0.ur")
"""Loggers of messages that companions have already logged."""
_ROUNDING: Final = 1e-6
"""Tolerance for comparisons of times [s]."""


class _Pace(NamedTuple):
    """Method by which a stream receives new states."""

    rate: float
    """Rate of the stream's subscription to the bus [Hz]."""
    interval: float
    """Wall time between two polls of the bus [s]."""
    is_woken: bool = False
    """Whether the tick thread wakes the event loop for each snapshot.  A wake-up
    requires one system call in the tick thread, but no call if the event loop is
    already awake."""
    is_fast: bool = False
    """Whether the newest snapshot is polled, which delays the tick only by the
    interpreter's switches to another thread."""

    @staticmethod
    def of(request: Subscribe, speed: float | None) -> _Pace:
        """Return the pace for a request at a speed of simulated time."""
        rate, default_rate = request.rate, 1.0 / SNAPSHOT_PERIOD
        if not request.newest_only:
            return _Pace(rate, POLL_PERIOD)
        if speed is None or rate / speed < min(rate, default_rate):
            return _Pace(min(rate, default_rate), _FAST_PERIOD, is_fast=True)
        return _Pace(rate / max(1.0, speed), _FLUSH_PERIOD, is_woken=True)


@final
class StateStream:
    """Stream of states and events to all sessions with the same request.

    The stream runs in the event loop, so its effect on the tick does not depend on the
    number of sessions.  A state is encoded once for all sessions.
    """

    def __init__(self, states: States, request: Subscribe) -> None:
        """Start sending states."""
        self._states = states
        self._request = request
        self._mask = StateMask(request.fields, request.controllers, request.arms)
        self._loop = asyncio.get_running_loop()
        self.opened: asyncio.Future[None] = self._loop.create_future()
        """Future that is done when states are received; fails with ControlError if no
        states can be received."""
        self._sessions: dict[Session, bool] = {}
        """Whether each session has received a complete state."""
        self._last: Snapshot | None = None
        """Newest snapshot that was sent."""
        self._due_time = -math.inf
        """Time of the last state that was due at the rate [s].  Additional states that
        are sent because of changes do not delay the next due state."""
        self._pace = _Pace.of(request, states.snapshot.speed)
        self._subscription: Subscription | None = None
        self._is_waking = False
        """Whether the event loop will send soon."""
        self._polled: Snapshot | None = None
        """Newest snapshot with arms, if arms are sent while simulated time runs
        fast."""
        self._task = asyncio.create_task(self._run())

    def add(self, session: Session) -> None:
        """Add a session, to which all later states are sent."""
        self._sessions[session] = False
        if self._request.newest_only and self._last is not None:
            self._send_to(session, self._last)

    def remove(self, session: Session) -> bool:
        """Remove a session; return whether there are other sessions."""
        self._sessions.pop(session, None)
        return bool(self._sessions)

    def send(self, text: bytes) -> None:
        """Send a message to every session."""
        for session in self._sessions:
            session.send(text)

    def close(self) -> None:
        """End the stream."""
        self._task.cancel()

    # ---- receiving from the bus ------------------------------------------------------

    async def _run(self) -> None:
        try:
            while True:
                await self._follow()
        except ControlError as error:  # invalid rate, or the simulation has ended
            if not self.opened.done():
                self.opened.set_exception(error)

    async def _follow(self) -> None:
        """Send the states of the bus until the speed of simulated time changes."""
        self._pace = pace = _Pace.of(self._request, self._states.snapshot.speed)
        self._subscription = await self._subscribed()
        if not self.opened.done():
            self.opened.set_result(None)
        try:
            while pace == _Pace.of(self._request, self._states.snapshot.speed):
                await asyncio.sleep(pace.interval)
                if pace.is_fast and self._mask.needs_arms:
                    read = self._states.snapshot_with_arms
                    self._polled = await asyncio.to_thread(read)
                self._deliver()
        finally:
            self._close(self._subscription)
            self._subscription = None

    async def _subscribed(self) -> Subscription:
        """Return a subscription.

        Another thread creates the subscription, because its creation waits for the
        tick.
        """
        made = asyncio.ensure_future(asyncio.to_thread(self._subscribe))
        try:
            return await asyncio.shield(made)
        except asyncio.CancelledError:
            made.add_done_callback(lambda made: self._close(made.result()))
            raise

    def _subscribe(self) -> Subscription:
        pace, mask = self._pace, self._mask
        subscription = self._states.subscribe(
            pace.rate,
            with_commands=mask.needs_commands,
            with_arms=mask.needs_arms and not pace.is_fast,
            with_contacts=mask.needs_contacts,
            latest_only=pace.is_fast,
            when_published=self._wake if pace.is_woken else None,
        )
        if not self._request.newest_only:
            subscription.pending()  # the stream starts with the next snapshot
        return subscription

    def _close(self, subscription: Subscription) -> None:
        """Close a subscription in another thread, which waits for the tick."""

        def close() -> None:
            with contextlib.suppress(ControlError):  # the simulation has ended
                subscription.close()

        self._loop.run_in_executor(None, close)

    def _wake(self) -> None:
        """Schedule sending in the event loop.

        This method is called in the tick thread.
        """
        if not self._is_waking:
            self._is_waking = True
            with contextlib.suppress(RuntimeError):  # the server has ended
                self._loop.call_soon_threadsafe(self._deliver)

    # ---- sending to the sessions -----------------------------------------------------

    def _deliver(self) -> None:
        """Send the states that have been received."""
        self._is_waking = False
        if self._subscription is None:
            return  # the subscription has ended
        try:
            self._send_events(self._subscription)
            for snapshot in self._arrived(self._subscription):
                if self._is_due(snapshot):
                    self._send_state(snapshot)
        except Exception:  # a failure must not end the stream
            logger.exception("a state could not be sent")

    def _send_events(self, subscription: Subscription) -> None:
        events = subscription.events
        while events:
            message = event_message(self._states, events.popleft())
            if message is not None:
                self.send(encode(message))

    def _arrived(self, subscription: Subscription) -> Sequence[Snapshot]:
        if self._pace.is_fast:
            return [self._polled or self._states.snapshot]
        return subscription.pending()

    def _is_due(self, now: Snapshot) -> bool:
        """Return whether a snapshot is due at this rate or contains another change."""
        if self._mask.needs_arms and not now.arms:
            return False  # from before the subscription
        before, pace = self._last, self._pace
        if before is None:
            self._due_time = now.time
            return True
        elapsed = now.time - self._due_time
        period = 0.0 if pace.is_fast else 1.0 / pace.rate - _ROUNDING
        if elapsed != 0.0 and not 0.0 <= elapsed < period:
            self._due_time = now.time
            return True
        return (
            now.controllers is not before.controllers
            or now.control_boxes is not before.control_boxes
            or now.is_paused != before.is_paused
            or now.is_stopped != before.is_stopped
        )

    def _send_state(self, snapshot: Snapshot) -> None:
        changes = encode(state_message(snapshot, self._mask, self._last))
        self._last = snapshot
        for session, is_complete in self._sessions.items():
            if session.missed or not is_complete:
                self._send_to(session, snapshot)
            else:
                session.send_snapshot(changes)

    def _send_to(self, session: Session, snapshot: Snapshot) -> None:
        """Send a complete state to one session."""
        missed, session.missed = session.missed, 0
        self._sessions[session] = True
        message = state_message(snapshot, self._mask, missed=missed)
        session.send_snapshot(encode(message))


@final
class StateStreams:
    """State streams of all sessions."""

    def __init__(self, states: States) -> None:
        self._states = states
        self._streams: dict[Subscribe, StateStream] = {}
        self._log: LogForwarder | None = None

    async def add(self, session: Session, request: Subscribe) -> None:
        """Send states to ``session``, in place of the states of its earlier request.

        Raises:
            ControlError: If a requested arm does not exist, or the rate is not
                supported.
        """
        known = [box.arm for box in self._states.snapshot.control_boxes]
        for arm in request.arms:
            if arm not in known:
                raise ControlError(f"no arm '{arm}'{did_you_mean(arm, known)}")
        self.remove(session)
        stream = self._streams.get(request)
        if stream is None:
            stream = self._streams[request] = StateStream(self._states, request)
        stream.add(session)
        if self._log is None:
            self._log = LogForwarder(self._send)
        try:
            await asyncio.shield(stream.opened)
        except ControlError:
            self.remove(session)
            raise

    def remove(self, session: Session) -> None:
        """Stop sending states to ``session``."""
        for request, stream in list(self._streams.items()):
            if not stream.remove(session):
                stream.close()
                del self._streams[request]
        if not self._streams and self._log is not None:
            self._log.close()
            self._log = None

    def close(self) -> None:
        """End every stream."""
        for stream in self._streams.values():
            stream.close()
        self._streams.clear()
        if self._log is not None:
            self._log.close()

    def _send(self, message: LogMessage) -> None:
        text = encode(message)
        for stream in self._streams.values():
            stream.send(text)


@final
class LogForwarder(logging.Handler):
    """Log handler that forwards tool0's warnings and errors in the event loop."""

    def __init__(self, send: Callable[[LogMessage], None]) -> None:
        super().__init__(logging.WARNING)
        self._event_loop = asyncio.get_running_loop()
        self._send = send
        logging.getLogger("tool0").addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Forward the record, and print it if the program has no log handler."""
        if not record.name.startswith(_COMPANION_LOGGERS):
            is_error = record.levelno >= logging.ERROR
            message = LogMessage(
                level="error" if is_error else "warning", message=record.getMessage()
            )
            with contextlib.suppress(RuntimeError):  # the server has ended
                self._event_loop.call_soon_threadsafe(self._send, message)
        if not logging.getLogger().handlers and logging.lastResort is not None:
            logging.lastResort.handle(record)

    def close(self) -> None:
        """Stop forwarding log records."""
        logging.getLogger("tool0").removeHandler(self)
        super().close()


def event_message(states: States, event: Event) -> EventMessage | None:
    """Return the message for an event; None if it is not sent.

    Some events are only sent to the panel and the log.
    """
    match event:
        case GoalFinished(goal):
            assert goal.result is not None  # the goal has finished
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
        case Reported() | WasFrozen():
            return None
