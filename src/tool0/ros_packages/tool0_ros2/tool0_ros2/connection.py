"""The connection to a bring-up.  Requests, replies and messages are lines of JSON.

``docs/reference/requests.md`` describes the protocol.
"""

import itertools
import json
import math
import socket
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any, TypeVar

from tool0_ros2.copied import folders, insecurity, is_foreign, socket_path
from tool0_ros2.errors import TransportError
from tool0_ros2.requests import (
    MAX_REQUEST,
    PROTOCOL,
    ErrorInfo,
    ErrorKind,
    GoalEnded,
    Hello,
    Message,
    Outcome,
    Reply,
    Request,
)

ANSWER_TIMEOUT = 30.0
"""Longest wait for an answer [wall s]."""
RETRY_PERIOD = 0.02
"""Pause between two attempts to connect [wall s]."""
OUTCOMES_KEPT = 1000
"""Number of outcomes that are kept for goals whose numbers are not yet known."""

T = TypeVar("T")


class RequestFailedError(Exception):
    """Raised if the simulation refused a request or did not answer."""

    def __init__(self, kind: ErrorKind, message: str, code: int | None = None) -> None:
        super().__init__(message)
        self.kind = kind
        self.code = code


class Connection:
    """A connection to a simulation in another process.

    Any thread may use a connection.

    A separate thread reads incoming messages.  The thread resolves the futures of
    requests and forwards other messages.
    """

    def __init__(self, name: str, *, wait: bool = False) -> None:
        """Connect to the bring-up named ``name``.

        With ``wait``, wait until a bring-up with this name exists.

        Raises:
            TransportError: If no connection is possible.
        """
        self.name = name
        self._peer = _connected(name, wait=wait)
        self._lines = self._peer.makefile("rb")
        hello: Hello = json.loads(self._lines.readline() or b"{}")
        protocol = hello.get("protocol")
        if protocol != PROTOCOL:
            raise TransportError(
                f"the bring-up '{name}' speaks protocol {protocol}, this "
                f"node {PROTOCOL}; run both from the same version of tool0"
            )
        if hello["mode"] not in {"simulation", "hardware"}:
            raise TransportError(
                f"'{name}' is a robot without physics; start one with `tool0 bringup`"
            )
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._sending = threading.Lock()
        self._pending: dict[int | str | None, Future[Any]] = {}
        self._goals: dict[int, Callable[[Outcome], None]] = {}
        self._outcomes: dict[int, Outcome] = {}
        self._has_ended = False
        self._reader = threading.Thread(target=self._read, name="tool0", daemon=True)
        self.on_message: Callable[[Message], None] = lambda message: None
        """Function that is called in the reader's thread for every message that is not
        an answer."""
        self.on_end: Callable[[str], None] = lambda reason: None
        """Function that is called once, in the reader's thread, when the connection has
        ended."""

    def start(self) -> None:
        """Start reading.

        Set ``on_message`` and ``on_end`` before calling this method.
        """
        self._reader.start()

    # ---- requests -----------------------------------------------------------------

    def call(self, request: Request[T], timeout: float | None = ANSWER_TIMEOUT) -> T:
        """Return the response to a request.

        Never call this method in the reader's thread, because the thread would wait for
        itself.

        Raises:
            RequestFailedError: If the request is refused, or if it is not answered in
                time.
        """
        try:
            return self.submit(request).result(timeout)
        except FutureTimeoutError:
            raise RequestFailedError(
                "TransportError",
                f"no answer to '{request.method}' within {timeout:g} s",
            ) from None

    def submit(self, request: Request[T]) -> "Future[T]":
        """Send a request and return its future.  Any thread may call this method."""
        number = next(self._numbers)
        future: Future[T] = Future()
        with self._lock:
            if self._has_ended:
                future.set_exception(_ENDED)
                return future
            self._pending[number] = future
        try:
            self._send({"id": number, **vars(request)})
        except RequestFailedError as error:
            with self._lock:
                self._pending.pop(number, None)
            future.set_exception(error)
        return future

    def post(self, request: Request[Any]) -> None:
        """Send a request without waiting.

        The simulation answers only to refuse the request.

        Raises:
            RequestFailedError: If the request cannot be sent.
        """
        self._send(vars(request))

    def when_finished(self, goal: int, callback: Callable[[Outcome], None]) -> None:
        """Call ``callback`` once, in any thread, with the outcome of a goal."""
        with self._lock:
            outcome = self._outcomes.pop(goal, None)
            if outcome is None:
                self._goals[goal] = callback
        if outcome is not None:
            callback(outcome)

    def close(self) -> None:
        """End the connection.  The simulation continues to run."""
        self._has_ended = True
        try:
            self._peer.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # the other side has already closed the connection
        if self._reader.is_alive() and threading.current_thread() is not self._reader:
            self._reader.join()
        self._lines.close()
        self._peer.close()

    def _send(self, message: dict[str, Any]) -> None:
        try:
            line = json.dumps(message, separators=(",", ":"), allow_nan=False)
        except ValueError:
            raise RequestFailedError(
                "RequestError", "a number is NaN or infinite"
            ) from None
        data = line.encode() + b"\n"
        if len(data) > MAX_REQUEST:
            raise RequestFailedError(
                "TransportError",
                f"a request of {len(data)} bytes is longer than {MAX_REQUEST}",
            )
        try:
            with self._sending:
                self._peer.sendall(data)
        except OSError:
            raise _ENDED from None

    # ---- the reader's thread --------------------------------------------------------

    def _read(self) -> None:
        reason = "the bring-up has ended"
        try:
            for line in self._lines:
                self._take(json.loads(line))
        except ValueError as error:
            if not self._has_ended:
                reason = f"unreadable message from the bring-up: {error}"
        except OSError:
            pass  # the connection has ended
        with self._lock:
            was_closed, self._has_ended = self._has_ended, True
            pending, self._pending = self._pending, {}
        for future in pending.values():
            future.set_exception(_ENDED)
        if not was_closed:
            self.on_end(reason)

    def _take(self, message: Message) -> None:
        if message["type"] == "reply" and message["id"] is not None:
            self._resolve(message)
            return
        if message["type"] == "goal_finished":
            self._finish(message)
        self.on_message(message)

    def _resolve(self, message: Reply) -> None:
        with self._lock:
            future = self._pending.pop(message["id"], None)
        if future is None:
            return
        error = message.get("error")
        if error is None:
            future.set_result(message.get("result"))
        else:
            future.set_exception(failure(error))

    def _finish(self, message: GoalEnded) -> None:
        number = message["goal"]
        if number is None:
            return
        with self._lock:
            callback = self._goals.pop(number, None)
            if callback is None:
                self._outcomes[number] = message["outcome"]
                if len(self._outcomes) > OUTCOMES_KEPT:
                    del self._outcomes[next(iter(self._outcomes))]
        if callback is not None:
            callback(message["outcome"])


def failure(error: ErrorInfo) -> RequestFailedError:
    """Return the exception for an error in a reply."""
    kind: Any = error["type"]
    return RequestFailedError(kind, error["message"], error.get("code"))


_ENDED = RequestFailedError("TransportError", "the bring-up has ended")


def _connected(name: str, *, wait: bool) -> socket.socket:
    end = math.inf if wait else time.monotonic()
    while True:
        problem = f"no bring-up named '{name}' is running; start `tool0 bringup`"
        for folder in folders():
            path = socket_path(folder, name)
            if not path.exists():
                continue
            if found := insecurity(folder):
                raise TransportError(found)
            peer = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                peer.connect(str(path))
            except (FileNotFoundError, ConnectionRefusedError):
                peer.close()  # the socket remains from a bring-up that was killed
                continue
            except OSError as error:
                peer.close()
                problem = f"cannot connect to {path}: {error.strerror}"
                continue
            if is_foreign(peer):
                peer.close()
                raise TransportError(f"another user's program listens on {path}")
            return peer
        if time.monotonic() >= end:
            raise TransportError(problem)
        time.sleep(RETRY_PERIOD)
