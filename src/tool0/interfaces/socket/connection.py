"""One visitor of a bringup: reads its requests in order, and answers each."""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import threading
from collections.abc import Callable
from typing import final

from tool0.errors import Tool0Error, TransportError, did_you_mean
from tool0.interfaces.socket.methods import CALLS, GOALS
from tool0.interfaces.socket.params import Params
from tool0.interfaces.socket.served_robot import ServedGoal, ServedRobot
from tool0.interfaces.socket.wire import (
    MAX_ANSWER,
    PROTOCOL,
    Json,
    LineReader,
    LineTooLongError,
    decode,
    encode,
    error_to_json,
    result_to_json,
)

logger = logging.getLogger(__name__)

_MAX_GOALS = 1000
"""Goals one connection may hold; the oldest finished one makes room."""
_MAX_WAITS = 64
"""Goals one connection may wait for at a time; each costs a thread."""
_GLANCE = 0.02
"""Time between looks at a goal that is waited for [wall s]."""


@final
class Connection:
    """One peer, from its first line to its last."""

    def __init__(
        self,
        robot: ServedRobot,
        name: str,
        peer: socket.socket,
        when_gone: Callable[[Connection], None],
    ) -> None:
        self._robot = robot
        self._name = name
        self._peer = peer
        self._when_gone = when_gone
        self._send_lock = threading.Lock()
        self._greeted = False
        self._goals: dict[int, ServedGoal] = {}
        self._next_goal = 1
        self._gone = threading.Event()
        self._n_waits = 0
        self._waits_lock = threading.Lock()

    def close(self) -> None:
        """Hang up: the thread that reads sees the end of the stream."""
        with contextlib.suppress(OSError):  # the peer was faster
            self._peer.shutdown(socket.SHUT_RDWR)

    def serve(self) -> None:
        """Answer requests until the peer or the server hangs up."""
        reader = LineReader(self._peer)
        try:
            while (line := reader.next_line()) is not None:
                if line.strip():
                    self._handle(line)
        except LineTooLongError as error:
            self._send({"id": None, "error": error_to_json(error)})
        except OSError:
            pass  # the peer died; there is nobody to tell
        finally:
            self._leave()

    def _leave(self) -> None:
        self._gone.set()
        self._when_gone(self)
        self.close()
        with self._send_lock:
            self._peer.close()

    def _handle(self, line: bytes) -> None:
        ident: object = None
        try:
            message = decode(line)
            ident = _ident(message)
            answer = self._answer(ident, message)
        except Tool0Error as error:
            self._send({"id": ident, "error": error_to_json(error)})
        except Exception as error:  # a fault of ours must not end the peer's session
            logger.exception("a remote request failed")
            self._send({"id": ident, "error": error_to_json(error)})
        else:
            if answer is not None:
                self._send({"id": ident, "result": answer})

    def _answer(self, ident: int | str, message: Json) -> Json | None:
        """Return the result, or None if it is sent later."""
        for key in message:
            if key not in ("id", "method", "params"):
                raise TransportError(f"a request has no key '{key}'")
        method = message.get("method")
        if not isinstance(method, str):
            raise TransportError("a request needs a 'method', a string")
        params = Params(method, message.get("params"))
        if method == "hello":
            return self._hello(params)
        if not self._greeted:
            raise TransportError(
                f"the first request must be 'hello' with protocol {PROTOCOL}"
            )
        if method in CALLS:
            return CALLS[method](self._robot, params)
        if method in GOALS:
            return {"goal": self._keep(GOALS[method](self._robot, params))}
        if method in ("goal.wait", "goal.status", "goal.cancel"):
            goal = self._goal(params)
            if method == "goal.wait":
                self._start_wait(ident, goal)
                return None
            if method == "goal.cancel":
                goal.cancel()
            return {"status": goal.status.value}
        valid = {*CALLS, *GOALS, "hello", "goal.wait", "goal.status", "goal.cancel"}
        raise TransportError(f"unknown method '{method}'{did_you_mean(method, valid)}")

    def _hello(self, params: Params) -> Json:
        protocol = params.count("protocol", default=0)
        params.finish()
        if protocol != PROTOCOL:
            raise TransportError(
                f"this bringup speaks protocol {PROTOCOL}, the client {protocol}; "
                "run both from the same version of tool0"
            )
        self._greeted = True
        return {"protocol": PROTOCOL, "name": self._name, "pid": os.getpid()}

    def _keep(self, goal: ServedGoal) -> int:
        if len(self._goals) >= _MAX_GOALS:
            ended = (k for k, v in self._goals.items() if v.status.is_terminal)
            oldest = next(ended, None)
            if oldest is None:
                goal.cancel()
                raise TransportError(f"more than {_MAX_GOALS} goals are in progress")
            del self._goals[oldest]
        number = self._next_goal
        self._next_goal += 1
        self._goals[number] = goal
        return number

    def _goal(self, params: Params) -> ServedGoal:
        number = params.count("goal", default=0)
        params.finish()
        if number not in self._goals:
            raise TransportError(f"this connection has no goal {number}")
        return self._goals[number]

    def _start_wait(self, ident: int | str, goal: ServedGoal) -> None:
        with self._waits_lock:
            if self._n_waits >= _MAX_WAITS:
                raise TransportError(f"more than {_MAX_WAITS} waits are in progress")
            self._n_waits += 1
        threading.Thread(
            target=self._wait, args=(ident, goal), name="tool0-remote-wait", daemon=True
        ).start()

    def _wait(self, ident: int | str, goal: ServedGoal) -> None:
        # Not goal.wait: without real time that would drive the simulation from here.
        while (result := goal.result) is None and not self._gone.wait(_GLANCE):
            pass
        with self._waits_lock:
            self._n_waits -= 1
        if result is not None:
            self._send({"id": ident, "result": result_to_json(result)})

    def _send(self, message: Json) -> None:
        try:
            line = encode(message, MAX_ANSWER)
        except (TransportError, TypeError, ValueError) as error:
            line = encode({"id": message["id"], "error": error_to_json(error)})
        # A peer that died is seen by the reading thread too.
        with self._send_lock, contextlib.suppress(OSError):
            self._peer.sendall(line)


def _ident(message: Json) -> int | str:
    ident = message.get("id")
    if isinstance(ident, bool) or not isinstance(ident, (int, str)):
        raise TransportError("a request needs an 'id', a number or a string")
    return ident
