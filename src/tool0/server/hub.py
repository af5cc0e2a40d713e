"""All connections of one robot, each of which can read and control the robot."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import socket
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib.metadata import version
from typing import Any, Final, Protocol, final

from tool0.errors import ControlError, Tool0Error
from tool0.protocol.arm import ListArms
from tool0.protocol.arm_motion import ReturnArm, TakeArm
from tool0.protocol.backend import Backend, missing
from tool0.protocol.codec import (
    PROTOCOL,
    GoalEnded,
    Hello,
    encode,
    encode_error,
    encode_reply,
    outcome_of,
)
from tool0.protocol.goals import Goal, GoalStarted
from tool0.protocol.motion import SteerJoints
from tool0.protocol.request import Request
from tool0.protocol.running import Run, Step
from tool0.protocol.subscriptions import Subscribe, SubscribeView, ViewShown
from tool0.server.budget import Budget
from tool0.server.outages import Outages
from tool0.server.session import Ident, Session, Transport
from tool0.server.setpoint_streams import SetpointStreams, StreamedSetpoint
from tool0.server.state_streams import StateStreams

logger = logging.getLogger(__name__)


_ADVANCING: Final = (Run, Step)
"""Requests that may execute ticks if the simulation does not run in real time.  The
processor time of these ticks is not charged to a client."""
_POST_COST: Final = 0.1e-3
"""Processor time of a streamed request in the tick thread [s]."""
_STREAM_COST: Final = 2e-3
"""Processor time for starting or ending a stream, which uses separate threads [s]."""


class Service(Protocol):
    """Acceptor of connections, which listens at an address after construction."""

    @property
    def listener(self) -> socket.socket: ...

    @property
    def starts_at_once(self) -> bool:
        """Whether the service starts before the first peer connects."""

    async def start(self, hub: Hub) -> None:
        """Accept peers; this coroutine runs in the server's event loop."""

    async def stop(self) -> None:
        """Stop accepting peers; afterwards, the hub closes the connections."""

    async def end(self) -> None:
        """End the remaining tasks of the service in the event loop."""

    def release(self) -> None:
        """Free the address, even if the service has not been started."""


WORKERS: Final = 16
"""Number of requests that are executed concurrently.  Additional requests are
queued."""
_CLOSE_TIMEOUT: Final = 0.5
"""Longest wait for a peer to close its connection [wall s]."""


@final
class Hub:
    """Executor of requests and source of streams in the server's event loop."""

    def __init__(self, backend: Backend, name: str) -> None:
        self.backend = backend
        self.budget = Budget()
        self.sessions: set[Session] = set()
        self._setpoints = SetpointStreams(self._carry_out_setpoint)
        states = backend.states
        self._streams = None if states is None else StateStreams(states)
        self._workers = ThreadPoolExecutor(WORKERS, "tool0-server-worker")
        # An emergency stop never has to wait for requests of other clients.
        self._urgent_worker = ThreadPoolExecutor(1, "tool0-server-stop")
        self._urgent: set[asyncio.Task[bool]] = set()
        self._outages = Outages()
        self.attach_view: Callable[[Session, SubscribeView], None] | None = None
        """Function that serves the panel's view to a session; None without a panel."""
        self.when_shown: Callable[[], None] = lambda: None
        """Callback that is called when a page has drawn the robot."""
        self.when_refused: Callable[[str], None] = lambda message: None
        """Callback that is called when a streamed setpoint was refused."""
        self.setpoint_requests: tuple[type[Request[Any]], ...] = (SteerJoints,)
        """Types of requests that are setpoints of a stream if they have no id."""
        self._hello = encode(
            Hello(
                protocol=PROTOCOL,
                version=version("tool0"),
                name=name,
                pid=os.getpid(),
                mode=backend.mode,
            )
        )

    async def serve(self, transport: Transport) -> None:
        """Serve a peer until it disconnects."""
        session = Session(transport, self._take_at_once, self._answer, self._stop)
        self.sessions.add(session)
        session.send(self._hello)
        try:
            await session.serve()
        finally:
            self._outages.forget(session)
            self.sessions.discard(session)
            if self._streams is not None:
                self._streams.remove(session)
            self._return_arms(session)

    async def close(self) -> None:
        """Close every connection, but complete requests that are being executed."""
        self._setpoints.close()
        if self._streams is not None:
            self._streams.close()
        sessions = list(self.sessions)
        await asyncio.gather(*map(_close, sessions))
        self._workers.shutdown(wait=False, cancel_futures=True)
        self._urgent_worker.shutdown(wait=False)

    def drop_stuck(self) -> None:
        """Drop the connections of peers that do not read their messages."""
        for session in list(self.sessions):
            if session.is_stuck():
                session.drop()

    def look_for_outage(self) -> None:
        """Drop waiting setpoints if this process was frozen.

        Call this method regularly.
        """
        if self._outages.look():
            self._setpoints.drop_all()

    # ---- requests -------------------------------------------------------------------

    def _take_at_once(
        self, session: Session, ident: Ident, request: Request[Any]
    ) -> bool:
        self.look_for_outage()
        refusal = (
            self._missing(request)
            or (session.files and session.files.refusal(request))
            or self._outages.refusal(session, request, is_streamed=ident is None)
        )
        if refusal is not None:
            self._refuse(session, ident, refusal)
            return True
        if ident is None and isinstance(request, self.setpoint_requests):
            try:
                self.backend.check_setpoint(request)
            except Exception as error:
                self._refuse(session, None, error)
            else:
                self._setpoints.submit(StreamedSetpoint(session, request))
            return True
        if ident is None and request.is_streamed and not session.is_busy:
            self._post(session, request)
            return True
        if request.is_urgent and not request.revokes:
            self._stop(session, ident, request)
            return True
        return False

    def _stop(self, session: Session, ident: Ident, request: Request[Any]) -> None:
        """Execute a stop request before all waiting requests."""
        if (refusal := self._missing(request)) is not None:
            self._refuse(session, ident, refusal)
            return
        self._setpoints.drop(self.backend.superseded(request))
        answer = self._carry_out(session, ident, request, self._urgent_worker)
        task = asyncio.create_task(answer)
        self._urgent.add(task)
        task.add_done_callback(self._urgent.discard)

    def _post(self, session: Session, request: Request[Any]) -> None:
        """Pass a request to the tick thread without waiting for its execution."""
        session.account.charge(_POST_COST)
        loop = asyncio.get_running_loop()

        def refuse(error: Exception) -> None:
            with contextlib.suppress(RuntimeError):  # the server has ended
                loop.call_soon_threadsafe(self._refuse, session, None, error)

        try:
            self.backend.post(request, refuse)
        except Tool0Error as error:
            self._refuse(session, None, error)

    def _missing(self, request: Request[Any]) -> ControlError | None:
        """Return the error for a request that the robot does not support, or None."""
        if request.is_of_connection:
            return None
        reason = self.backend.why_missing(type(request))
        return missing(type(request), reason) if reason else None

    def _refuse(self, session: Session, ident: Ident, error: Exception) -> None:
        """Send an error; equal errors of a stream are sent at most once per second."""
        if ident is not None or self._outages.is_new(session, str(error)):
            session.send(encode_error(ident, _logged(error)))

    async def _answer(
        self, session: Session, ident: Ident, request: Request[Any]
    ) -> None:
        if isinstance(request, ViewShown):
            self.when_shown()
            session.send(encode_reply(ident, request, None))
            return
        if request.is_of_connection:
            session.account.charge(_STREAM_COST)
            await self._change_streams(session, ident, request)
            return
        await self._setpoints.settle(self.backend.superseded(request))
        workers = self._urgent_worker if request.is_urgent else self._workers
        if not await self._carry_out(session, ident, request, workers):
            return
        if isinstance(request, TakeArm | ReturnArm):
            self._note_taken(session, request)

    def _note_taken(self, session: Session, request: TakeArm | ReturnArm) -> None:
        """Record which peer moves an arm after the request has been executed."""
        arm = request.arm
        if arm is None:  # the only arm
            arm = self.backend.answer(ListArms())[0].name
        by = None if isinstance(request, TakeArm) else request.by
        for other in self.sessions:
            if by is None or other.arms.get(arm) == by:
                other.arms.pop(arm, None)
        if isinstance(request, TakeArm):
            session.arms[arm] = request.by

    async def _change_streams(
        self,
        session: Session,
        ident: Ident,
        request: Request[Any],
    ) -> None:
        reply = encode_reply(ident, request, None)
        if isinstance(request, SubscribeView):
            if self.attach_view is None:
                error = ControlError("this bring-up has no panel (--headless)")
                session.send(encode_error(ident, error))
            else:
                session.send(reply)
                self.attach_view(session, request)
        elif self._streams is None:
            error = ControlError("a robot without physics has no states")
            session.send(encode_error(ident, error))
        else:
            try:
                if isinstance(request, Subscribe):
                    await self._streams.add(session, request)
                else:
                    self._streams.remove(session)
            except ControlError as refused:
                reply = encode_error(ident, refused)
            session.send(reply)

    def _return_arms(self, session: Session) -> None:
        """Stop the arms that a peer controls, and release them."""
        for arm, by in session.arms.items():
            with contextlib.suppress(RuntimeError):  # the server is ending
                self._workers.submit(self._return_arm, ReturnArm(arm=arm, by=by))

    def _return_arm(self, request: ReturnArm) -> None:
        with contextlib.suppress(Tool0Error):  # the simulation has ended
            self.backend.answer(request)

    async def _carry_out(
        self,
        session: Session,
        ident: Ident,
        request: Request[Any],
        workers: ThreadPoolExecutor,
    ) -> bool:
        """Execute a request and send the reply.

        Return whether the request succeeded.
        """
        loop = asyncio.get_running_loop()
        try:
            text, goals, seconds = await loop.run_in_executor(
                workers, self._reply, ident, request
            )
        except Exception as error:
            session.send(encode_error(ident, _logged(error)))
            return False
        session.account.charge(seconds)
        if ident is not None:
            session.send(text)
        for number, goal in goals:
            goal.when_finished(partial(self._report_end, loop, session, number))
        return True

    def _reply(
        self, ident: Ident, request: Request[Any]
    ) -> tuple[bytes, list[tuple[int, Goal]], float]:
        """Return the reply, the started goals and the processor time [s].

        This method runs in a worker thread.
        """
        start = time.thread_time()
        response = self.backend.answer(request)
        started = response if isinstance(response, tuple) else (response,)
        states = self.backend.states
        goals = [
            (item.goal, states.goals.find(item.goal))
            for item in started
            if isinstance(item, GoalStarted) and states is not None
        ]
        text = encode_reply(ident, request, response)
        is_paid = not isinstance(request, _ADVANCING)
        return text, goals, (time.thread_time() - start) * is_paid

    def _report_end(
        self,
        loop: asyncio.AbstractEventLoop,
        session: Session,
        number: int,
        goal: Goal,
    ) -> None:
        """Report the end of a goal to the connection that started it."""
        assert goal.result is not None  # the goal has finished
        message = GoalEnded(
            goal=number, controller=goal.controller, outcome=outcome_of(goal.result)
        )
        with contextlib.suppress(RuntimeError):  # the server has ended
            loop.call_soon_threadsafe(session.send, encode(message))

    async def _carry_out_setpoint(self, setpoint: StreamedSetpoint) -> None:
        loop = asyncio.get_running_loop()
        carry_out = self.backend.answer
        try:
            await loop.run_in_executor(self._workers, carry_out, setpoint.request)
        except Exception as error:
            sender = setpoint.sender
            if isinstance(sender, Session) and sender in self.sessions:
                sender.send(encode_error(None, _logged(error)))
            self.when_refused(str(error))


async def _close(session: Session) -> None:
    with contextlib.suppress(Exception):  # may be closed or stuck
        await asyncio.wait_for(session.close(), _CLOSE_TIMEOUT)


def _logged(error: Exception) -> Exception:
    if not isinstance(error, Tool0Error):
        logger.error("a request failed", exc_info=error)
    return error


_CHECK_PERIOD: Final = 0.1
"""Wall time between checks for outages and for connections that do not read [s]."""


async def serve(
    backend: Backend, services: Sequence[Service], name: str, wake: socket.socket
) -> None:
    """Serve a robot until ``wake`` becomes readable."""
    wake.setblocking(False)
    stop = asyncio.create_task(asyncio.get_running_loop().sock_recv(wake, 1))
    hub = Hub(backend, name)
    for service in services:
        await service.start(hub)
    while not stop.done():
        await asyncio.wait([stop], timeout=_CHECK_PERIOD)
        hub.look_for_outage()
        hub.drop_stuck()
    for service in services:
        await service.stop()
    await hub.close()
    for service in services:
        await service.end()
