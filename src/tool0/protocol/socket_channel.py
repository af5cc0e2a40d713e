"""A connection to a backend in another process, over its Unix socket."""

from __future__ import annotations

import contextlib
import itertools
import math
import socket
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn, TypeVar, final

import msgspec
from msgspec import Raw, UnsetType

from tool0.errors import Tool0Error, TransportError
from tool0.protocol import codec
from tool0.protocol.address import (
    DEFAULT_NAME,
    check_supported,
    folders,
    insecurity,
    is_foreign,
    running_names,
    socket_path,
)
from tool0.protocol.bus import (
    Bus,
    Faulted,
    GoalFinished,
    Overran,
    Subscription,
    WasReset,
)
from tool0.protocol.fork_guard import refuse_pickle
from tool0.protocol.goal_registry import GOALS_KEPT
from tool0.protocol.goals import Goal, GoalStarted
from tool0.protocol.request import Request, checked, method_name
from tool0.protocol.robot import ReadDescription, ReadSnapshot
from tool0.protocol.running import Run, Step
from tool0.protocol.state import Snapshot
from tool0.protocol.state_message import StateMessage, snapshot_of
from tool0.protocol.subscriptions import LogMessage, Subscribe, Unsubscribe

if TYPE_CHECKING:
    from tool0.description.robot import RobotDescription

R = TypeVar("R")
V = TypeVar("V")

ANSWER_TIMEOUT: Final = 30.0
"""Longest wait for a reply to a request that is answered immediately [wall s]."""
POLL_PERIOD: Final = 0.02
"""Wall time between polls of the state [s]."""
MAX_REQUEST: Final = 1 << 23
"""Maximum size of a request [bytes], which is sufficient for 10 000 trajectory points
of 6 joints with velocities and accelerations."""


@final
class SocketChannel:
    """A connection to a robot in another process: JSON lines over its Unix socket.

    The channel is thread-safe.  A separate thread reads incoming messages.
    """

    def __init__(self, name: str = DEFAULT_NAME) -> None:
        """Connect to a bring-up; raise TransportError if this is impossible."""
        self.name = name
        self.when_refused: Callable[[Tool0Error], None] = self._give_up
        """Callback for a failed request without a reply, called in the reader's
        thread."""
        self.when_ended: Callable[[TransportError], None] = lambda failure: None
        """Callback for the end of the connection, called once in the reader's
        thread."""
        self._peer = _connect(name)
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._sending = threading.Lock()
        self._pending: dict[int, Future[codec.Reply]] = {}
        self._goals: dict[int, Goal] = {}
        self._bus = Bus()
        self._failure: TransportError | None = None
        self._hello: Future[codec.Hello] = Future()
        self._reader = threading.Thread(
            target=self._read, name="tool0-connection", daemon=True
        )
        self._reader.start()
        try:
            self.hello = self._greeted()
        except BaseException:
            self.close()
            raise

    def __reduce__(self) -> NoReturn:
        refuse_pickle()

    @cached_property
    def description(self) -> RobotDescription:
        """Description of the robot, from the URDF that the bring-up sends."""
        info = self.call(ReadDescription())
        from tool0.description.xml_source import parse_text
        from tool0.protocol.received_description import described_by

        return described_by(info, parse_text(info.urdf))

    @property
    def snapshot(self) -> Snapshot:
        return self.call(ReadSnapshot())

    @property
    def time(self) -> float:
        return self.snapshot.time

    def call(self, request: Request[R]) -> R:
        """Return the response, or raise the handler's error.

        Raises:
            TransportError: If the bring-up does not answer, or if it has ended.
        """
        future = self._submit(request)
        # A request that advances time is answered only after this time has passed.
        timeout = None if isinstance(request, Run | Step) else ANSWER_TIMEOUT
        reply = self._awaited(future, timeout, method_name(type(request)))
        return _response(request, reply)

    def submit(
        self, request: Request[R], when_done: Callable[[Callable[[], R]], None]
    ) -> None:
        """Send a request without waiting; call ``when_done`` after the reply.

        ``when_done`` is called in the reader's thread with a function that returns the
        response or raises the handler's error.

        Raises:
            RequestError: If the request is invalid.
            TransportError: If the bring-up has ended.
        """

        def finish(future: Future[codec.Reply]) -> None:
            when_done(lambda: _response(request, future.result()))

        self._submit(request).add_done_callback(finish)

    def post(self, request: Request[Any]) -> None:
        """Send a request without a reply; ``when_refused`` receives errors."""
        self._send(codec.encode_request(None, checked(request)) + b"\n")

    def _submit(self, request: Request[Any]) -> Future[codec.Reply]:
        self._bus.process.check()
        request = checked(request)
        number = next(self._numbers)
        line = codec.encode_request(number, request) + b"\n"
        if len(line) > MAX_REQUEST:
            raise TransportError(
                f"a request of {len(line)} bytes is longer than {MAX_REQUEST}; "
                "send fewer waypoints"
            )
        future: Future[codec.Reply] = Future()
        with self._lock:
            if self._failure is not None:
                raise self._failure
            self._pending[number] = future
        self._send(line)
        return future

    def goal(self, started: GoalStarted) -> Goal:
        return self._goal(started.goal, started.controller)

    def wait_until(self, is_over: Callable[[], bool], timeout: float | None) -> bool:
        self._bus.process.check()
        end = time.monotonic() + (math.inf if timeout is None else timeout)
        while not is_over():
            if not time.monotonic() < end:
                return False
            time.sleep(POLL_PERIOD)
        return True

    def wait_for_goal(self, goal: Goal, timeout: float | None) -> bool:
        self._bus.process.check()
        end = time.monotonic() + (math.inf if timeout is None else timeout)
        while not goal.wait(max(0.0, min(0.1, end - time.monotonic()))):
            if self._failure is not None:
                raise self._failure
            if not time.monotonic() < end:
                return False
        return True

    def subscribe(
        self, rate: float | None = None, *, keep_all: bool = False
    ) -> Subscription:
        """Return a reader.

        The connection has a single rate: the last requested rate.
        """
        request = Subscribe() if rate is None else Subscribe(rate=rate)
        return self.follow(request, keep_all=keep_all)

    def follow(
        self,
        request: Subscribe,
        *,
        keep_all: bool = False,
        when_published: Callable[[], None] | None = None,
    ) -> Subscription:
        """Return a reader of the requested states.

        This is the only stream of the connection.  The reader's thread calls
        ``when_published`` for every snapshot.
        """
        subscription = self._bus.subscribe(
            when_closed=self._unsubscribe,
            keep_all=keep_all,
            when_published=when_published,
        )
        self.call(request)
        return subscription

    def close(self) -> None:
        """End the connection; the robot keeps running."""
        if not self._bus.process.is_this:
            return  # only the parent of a forked child closes the connection
        self._fail(TransportError("the connection is closed"))
        with contextlib.suppress(OSError):  # the peer has closed the connection
            self._peer.shutdown(socket.SHUT_RDWR)
        if threading.current_thread() is not self._reader:
            self._reader.join()
        self._peer.close()

    def _greeted(self) -> codec.Hello:
        hello = self._awaited(self._hello, ANSWER_TIMEOUT, "hello")
        if hello.protocol != codec.PROTOCOL:
            raise TransportError(
                f"this bring-up speaks protocol {hello.protocol}, the client "
                f"{codec.PROTOCOL}; run both from the same version of tool0"
            )
        return hello

    def _unsubscribe(self) -> None:
        if not self._bus.has_subscribers and self._failure is None:
            self.call(Unsubscribe())

    def _send(self, line: bytes) -> None:
        try:
            with self._sending:
                self._peer.sendall(line)
        except TimeoutError:
            raise TransportError("the bring-up does not read its requests") from None
        except OSError as error:
            raise TransportError(f"lost the bring-up: {error}") from None

    def _awaited(self, future: Future[V], timeout: float | None, what: str) -> V:
        try:
            return future.result(timeout)
        except FutureTimeoutError:
            raise TransportError(
                f"the bring-up did not answer '{what}' within {timeout:g} s"
            ) from None

    # ---- the reader's thread --------------------------------------------------------

    def _read(self) -> None:
        failure = TransportError("the bring-up has ended")
        try:
            with self._peer.makefile("rb") as lines:
                for line in lines:
                    self._take(_decoder.decode(line))
        except (msgspec.DecodeError, Tool0Error) as error:
            failure = TransportError(f"unreadable message from the bring-up: {error}")
        except (OSError, ValueError) as error:
            failure = TransportError(f"lost the bring-up: {error}")
        self._fail(failure)
        self.when_ended(failure)

    def _take(self, message: Message) -> None:
        match message:
            case codec.Reply(id=int(number)):
                with self._lock:
                    future = self._pending.pop(number, None)
                if future is not None:
                    future.set_result(message)
            case codec.Reply(error=codec.ErrorInfo() as info):
                self.when_refused(codec.error_of(info))
            case StateMessage():
                self._bus.publish(snapshot_of(message, self._bus.latest))
            case codec.GoalEnded(goal=int(number)):
                goal = self._goal(number, message.controller)
                if not goal.status.is_terminal:
                    goal.finish(codec.result_of(message.outcome))
                    self._bus.announce(GoalFinished(goal))
            case codec.Fault(message=text, time=at):
                self._bus.announce(Faulted(text, at))
            case codec.ResetDone(time=at):
                self._bus.announce(WasReset(at))
            case codec.LateTicks(count=count, time=at):
                self._bus.announce(Overran(count, at))
            case codec.Hello():
                self._hello.set_result(message)

    def _goal(self, number: int, controller: str) -> Goal:
        """Return the goal with this number; create it if it does not exist."""
        with self._lock:
            if number not in self._goals:
                self._goals[number] = Goal(controller)
                if len(self._goals) > GOALS_KEPT:
                    ended = (n for n, g in self._goals.items() if g.status.is_terminal)
                    self._goals.pop(next(ended, -1), None)
            return self._goals[number]

    def _give_up(self, error: Tool0Error) -> None:
        self._fail(TransportError(f"the bring-up answered: {error}"))

    def _fail(self, failure: TransportError) -> None:
        """Wake every waiting thread with an error."""
        with self._lock:
            self._failure = self._failure or failure
            pending, self._pending = list(self._pending.values()), {}
        futures: list[Future[Any]] = [*pending, self._hello]
        for future in futures:
            if not future.done():
                future.set_exception(failure)


def _response(request: Request[R], reply: codec.Reply) -> R:
    """Return a reply's response, or raise the reply's error."""
    if not isinstance(reply.error, UnsetType):
        raise codec.error_of(reply.error)
    result = b"null" if isinstance(reply.result, UnsetType) else reply.result
    response: R = codec.decode_response(request, Raw(result))
    return response


Message = codec.Hello | codec.Reply | StateMessage | codec.EventMessage | LogMessage
_decoder: Final = msgspec.json.Decoder(Message)


def _connect(name: str) -> socket.socket:
    check_supported()
    paths = [socket_path(folder, name) for folder in folders()]
    for path in paths:
        try:
            return _trusted(path)
        except (FileNotFoundError, ConnectionRefusedError):
            pass  # not started, or ended without removing the file
        except OSError as error:
            raise TransportError(f"cannot reach {path}: {error}") from None
    others = [other for other in running_names() if other != name]
    hint = (
        f"running: {', '.join(others)} (use --name)"
        if others
        else "start one with `tool0 bringup`"
    )
    raise TransportError(f"no bringup named '{name}' is running ({paths[0]}); {hint}")


def _trusted(path: Path) -> socket.socket:
    """Return a socket connected to a bring-up of this user."""
    if (problem := insecurity(path.parent)) is not None:
        raise TransportError(f"{path} may be another user's: {problem}")
    peer = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        peer.connect(str(path))
    except OSError:
        peer.close()
        raise
    if is_foreign(peer):
        peer.close()
        raise TransportError(f"{path} is served by another user")
    return peer
