"""What the visitor's end of the socket asks: requests, and goals that they start.

A connection belongs to one thread.  Times to wait are wall seconds, since the other
side's clock may be paused.
"""

from __future__ import annotations

import socket
import time
from typing import Final, Protocol, final

from tool0.control.goal import GoalStatus, Result
from tool0.errors import GoalTimeoutError, TransportError
from tool0.interfaces.socket.wire import (
    MAX_ANSWER,
    Json,
    LineReader,
    decode,
    encode,
    error_from_json,
    result_from_json,
)

ANSWER_TIMEOUT: Final = 30.0
"""Longest wait for an answer that should come at once [wall s]."""


class Call(Protocol):
    """Asks the other process for something, and returns its answer."""

    def __call__(self, method: str, **params: object) -> Json: ...


class Start(Protocol):
    """Starts a goal in the other process, and returns a handle on it."""

    def __call__(self, method: str, **params: object) -> RemoteGoal: ...


@final
class Requests:
    """Requests out, answers in, matched by id."""

    def __init__(self, peer: socket.socket) -> None:
        self._peer = peer
        self._reader = LineReader(peer, MAX_ANSWER)
        self._last_id = 0
        self._early: dict[int, Json] = {}

    def close(self) -> None:
        self._peer.close()

    def call(self, method: str, **params: object) -> Json:
        """Return the result of ``method``, or raise what it raised over there."""
        try:
            return self.receive(self.send(method, **params), ANSWER_TIMEOUT)
        except TimeoutError:
            raise TransportError(
                f"the bringup did not answer '{method}' within {ANSWER_TIMEOUT:g} s"
            ) from None

    def start(self, method: str, **params: object) -> RemoteGoal:
        """Have ``method`` start a goal, and return a handle on it."""
        return RemoteGoal(self, int(self.call(method, **params)["goal"]))

    def send(self, method: str, **params: object) -> int:
        """Send a request and return its id."""
        self._last_id += 1
        request = {"id": self._last_id, "method": method, "params": params}
        line = encode(request)
        try:
            self._peer.settimeout(ANSWER_TIMEOUT)
            self._peer.sendall(line)
        except TimeoutError:
            raise TransportError("the bringup does not read its requests") from None
        except OSError as error:
            raise TransportError(f"the bringup has gone: {error}") from None
        return self._last_id

    def receive(self, ident: int, timeout: float | None) -> Json:
        """Return the result of request ``ident``; keep those of others for later."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while ident not in self._early:
            try:
                self._peer.settimeout(
                    None if deadline is None else max(deadline - time.monotonic(), 1e-6)
                )
                line = self._reader.next_line()
            except TimeoutError:
                raise TimeoutError(f"no answer within {timeout} s") from None
            except OSError as error:
                raise TransportError(f"the bringup has gone: {error}") from None
            if line is None:
                raise TransportError("the bringup has ended")
            answer = decode(line)
            if answer.get("id") is None:
                raise error_from_json(answer.get("error"))
            self._early[answer["id"]] = answer
        answer = self._early.pop(ident)
        if "error" in answer:
            raise error_from_json(answer["error"])
        result = answer.get("result")
        if not isinstance(result, dict):
            raise TransportError(f"the bringup answered without a result: {answer!r}")
        return result


@final
class RemoteGoal:
    """A goal that a controller of another process accepted."""

    def __init__(self, requests: Requests, number: int) -> None:
        self._requests = requests
        self._number = number
        self._request: int | None = None
        self._result: Result | None = None

    @property
    def status(self) -> GoalStatus:
        answer = self._requests.call("goal.status", goal=self._number)
        return GoalStatus(answer["status"])

    @property
    def result(self) -> Result | None:
        """How it ended; None while it is active."""
        if self._result is None and self.status.is_terminal:
            return self.wait(ANSWER_TIMEOUT)
        return self._result

    def wait(self, timeout: float | None = None) -> Result:
        """Return how it ended, or raise GoalTimeoutError after ``timeout`` wall s.

        The goal goes on after a timeout, and may be waited for again.
        """
        if self._result is None:
            if self._request is None:
                self._request = self._requests.send("goal.wait", goal=self._number)
            try:
                answer = self._requests.receive(self._request, timeout)
            except TimeoutError:
                raise GoalTimeoutError(
                    f"the goal is still active after {timeout} s"
                ) from None
            self._result = result_from_json(answer)
        return self._result

    def cancel(self) -> None:
        """Stop the motion, as the controller stops on a canceled goal."""
        self._requests.call("goal.cancel", goal=self._number)
