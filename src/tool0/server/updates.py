"""Streams of control updates, one for each session that asks."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable
from typing import Final, final

from tool0.errors import ControlError, did_you_mean
from tool0.protocol.backend import States
from tool0.protocol.bus import Faulted, Subscription, WasReset
from tool0.protocol.codec import encode
from tool0.protocol.state import SNAPSHOT_PERIOD, Snapshot
from tool0.protocol.updates import LogMessage, SubscribeUpdates, update_message
from tool0.server.session import Session
from tool0.server.streams import event_message

logger = logging.getLogger(__name__)

_FLUSH_PERIOD: Final = 0.05
"""Wall time after which an update that was held back is sent anyway [s]."""
_POLL_PERIOD: Final = 0.02
"""Wall time between updates while simulated time runs fast [s]: each delays the tick by
some 0.4 ms, since both need the interpreter."""
_COMPANION_LOGGERS: Final = ("tool0.ros2", "tool0.ur")
"""Loggers with what these processes have logged themselves."""
_ROUNDING: Final = 1e-6
"""[s]"""


@final
class UpdateStream:
    """Sends updates to one session, in the event loop.

    The thread of the tick wakes the event loop for each snapshot; that costs it one
    system call, and none while the event loop is awake already.
    """

    def __init__(
        self, states: States, session: Session, request: SubscribeUpdates
    ) -> None:
        """Send nothing yet; ``run`` does until it is cancelled."""
        self._states = states
        self._session = session
        self._request = request
        self._loop = asyncio.get_running_loop()
        self._last: Snapshot | None = None
        self._speed = states.snapshot.speed
        self._subscription: Subscription | None = None
        self._is_waking = False
        """Whether the event loop is about to send."""
        self._wall_period = 0.0
        """Wall time between updates [s]; 0 sends every one."""
        self._polled: Snapshot | None = None
        """The newest one with arms, if they are sent while time runs fast."""
        self._period = 0.0
        """Shortest simulated time between updates [s]."""

    async def run(self) -> None:
        """Send every update that is due, until this is cancelled."""
        with contextlib.suppress(ControlError):  # the simulation has ended
            await self._run()

    async def _run(self) -> None:
        while True:
            self._subscription = await self._subscribed()
            try:
                while self._states.snapshot.speed == self._speed:
                    await asyncio.sleep(self._wall_period or _FLUSH_PERIOD)
                    if self._wall_period and self._request.arms:
                        read = self._states.snapshot_with_arms
                        self._polled = await asyncio.to_thread(read)
                    self._deliver()
            finally:
                self._close(self._subscription)
                self._subscription = None
            self._speed = self._states.snapshot.speed

    async def _subscribed(self) -> Subscription:
        """Return a subscription, made in another thread: it waits for the tick."""
        made = asyncio.ensure_future(asyncio.to_thread(self._subscribe))
        try:
            return await asyncio.shield(made)
        except asyncio.CancelledError:
            made.add_done_callback(lambda made: self._close(made.result()))
            raise

    def _close(self, subscription: Subscription) -> None:
        """Close a subscription in another thread."""

        def close() -> None:
            with contextlib.suppress(ControlError):  # the simulation has ended
                subscription.close()

        self._loop.run_in_executor(None, close)

    def _subscribe(self) -> Subscription:
        """Subscribe at a rate that suits the speed of simulated time.

        If time runs fast, the newest snapshot is polled: then the stream costs the tick
        nothing but what the interpreter does for another thread.
        """
        rate, speed = self._request.rate, self._speed
        default_rate = 1.0 / SNAPSHOT_PERIOD
        is_fast = speed is None or rate / speed < min(rate, default_rate)
        suitable = min(rate, default_rate) if is_fast else rate / max(1.0, speed or 1.0)
        self._wall_period = _POLL_PERIOD if is_fast else 0.0
        self._period = 0.0 if is_fast else 1.0 / suitable - _ROUNDING
        return self._states.subscribe(
            suitable,
            with_commands=bool(self._request.motions),
            with_arms=bool(self._request.arms) and not is_fast,
            latest_only=is_fast,
            when_published=None if is_fast else self._wake,
        )

    def _wake(self) -> None:
        """Let the event loop send; in the thread of the tick."""
        if not self._is_waking:
            self._is_waking = True
            with contextlib.suppress(RuntimeError):  # the server has ended
                self._loop.call_soon_threadsafe(self._deliver)

    def _deliver(self) -> None:
        """Send what has arrived."""
        self._is_waking = False
        if self._subscription is None:
            return  # it has just ended
        try:
            self._send(self._subscription)
        except Exception:  # one failure must not end the stream
            logger.exception("an update could not be sent")

    def _send(self, subscription: Subscription) -> None:
        events = subscription.events
        while events:
            event = events.popleft()
            if isinstance(event, Faulted | WasReset):
                self._session.send(encode(event_message(self._states, event)))
        is_polled = bool(self._wall_period)
        newest = [self._polled or self._states.snapshot]
        request = self._request
        for snapshot in newest if is_polled else subscription.pending():
            before = self._last
            if request.arms and not snapshot.arms:
                continue  # from before the subscription
            if before is not None and not self._is_due(before, snapshot):
                continue
            message = update_message(snapshot, before, request.motions, request.arms)
            self._last = snapshot
            self._session.send_snapshot(encode(message))

    def _is_due(self, before: Snapshot, now: Snapshot) -> bool:
        """Return whether a snapshot shows another update, or a change besides."""
        elapsed = now.time - before.time
        return (
            (elapsed != 0.0 and not 0.0 <= elapsed < self._period)
            or now.controllers is not before.controllers
            or now.control_boxes is not before.control_boxes
            or now.is_paused != before.is_paused
            or now.is_stopped != before.is_stopped
        )


@final
class LogForwarder(logging.Handler):
    """Passes warnings and errors of tool0 on, in the event loop.

    A program without logging handlers still sees them on standard error.
    """

    def __init__(self, send: Callable[[LogMessage], None]) -> None:
        super().__init__(logging.WARNING)
        self._event_loop = asyncio.get_running_loop()
        self._send = send
        logging.getLogger("tool0").addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Pass the record on; print it if the program has no handler."""
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
        """Pass nothing on any more."""
        logging.getLogger("tool0").removeHandler(self)
        super().close()


@final
class UpdateStreams:
    """The streams of all sessions."""

    def __init__(self, states: States) -> None:
        self._states = states
        self._tasks: dict[Session, asyncio.Task[None]] = {}
        self._log: LogForwarder | None = None

    def add(self, session: Session, request: SubscribeUpdates) -> None:
        """Let ``session`` receive updates, in place of those it has received.

        Raises:
            ControlError: If there is no arm of a requested name.
        """
        known = [box.arm for box in self._states.snapshot.control_boxes]
        for arm in request.arms:
            if arm not in known:
                raise ControlError(f"no arm '{arm}'{did_you_mean(arm, known)}")
        self.remove(session)
        if self._log is None:
            self._log = LogForwarder(self._send)
        stream = UpdateStream(self._states, session, request)
        self._tasks[session] = asyncio.create_task(stream.run())

    def remove(self, session: Session) -> None:
        """Stop sending to ``session``."""
        task = self._tasks.pop(session, None)
        if task is not None:
            task.cancel()
        if not self._tasks and self._log is not None:
            self._log.close()
            self._log = None

    def close(self) -> None:
        """End every stream."""
        for session in list(self._tasks):
            self.remove(session)

    def _send(self, message: LogMessage) -> None:
        text = encode(message)
        for session in self._tasks:
            session.send(text)
