"""A panel page without a browser: a WebSocket client of the server."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit, urlunsplit

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

TIMEOUT = 30.0
"""Longest wait for anything [wall s]."""

Message = dict[str, Any]


def socket_url(url: str) -> str:
    """Return the address of the WebSocket of the page at ``url``."""
    parts = urlsplit(url)
    return urlunsplit(("ws", parts.netloc, "/ws", parts.query, ""))


class Page:
    """A client that has subscribed to the view."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self._number = 0
        self._kept: list[Message] = []
        self._newest: dict[str, Message] = {}
        self.hello = self.next("hello")
        assert self.request("subscribe_view") is None
        self.view = self.next("view")

    def receive(self, deadline: float) -> Message:
        text = self.socket.recv(max(0.0, deadline - time.monotonic()))
        message: Message = json.loads(text)
        self._newest[message["type"]] = message
        return message

    def next(
        self, kind: str, condition: Callable[[Message], bool] = lambda _: True
    ) -> Message:
        """Return the next message of a type that meets ``condition``.

        Notices, replies and events that come meanwhile are kept for later.
        """
        for message in self._kept:
            if message["type"] == kind and condition(message):
                self._kept.remove(message)
                return message
        deadline = time.monotonic() + TIMEOUT
        while True:
            message = self.receive(deadline)
            if message["type"] == kind and condition(message):
                return message
            if message["type"] in ("notice", "reply", "goal_finished"):
                self._kept.append(message)

    def wait_for(self, kind: str, condition: Callable[[Message], bool]) -> Message:
        """Return the newest message of a type as soon as it meets ``condition``."""
        newest = self._newest.get(kind)
        if newest is not None and condition(newest):
            return newest
        return self.next(kind, condition)

    def close_code(self) -> int:
        """Read until the server ends the connection, and return the code it gave."""
        try:
            while True:
                self.socket.recv(TIMEOUT)
        except ConnectionClosed as closed:
            return 0 if closed.rcvd is None else closed.rcvd.code

    def send(self, method: str, **params: Any) -> None:
        """Send a setpoint of a stream: a request without an id."""
        self.socket.send(json.dumps({"method": method, "params": params}))

    def start(self, method: str, **params: Any) -> int:
        """Send a request, and return its id."""
        self._number += 1
        text = json.dumps({"id": self._number, "method": method, "params": params})
        self.socket.send(text)
        return self._number

    def request(self, method: str, **params: Any) -> Message | None:
        """Send a request, wait for its reply, and return the error in it."""
        number = self.start(method, **params)
        reply = self.next("reply", lambda message: message["id"] == number)
        error: Message | None = reply.get("error")
        return error

    def position(self, joint: str, frame: Message) -> float:
        """Return where a joint is in a frame [rad | m]."""
        names = [item["name"] for item in self.view["robot"]["joints"]]
        position: float = frame["position"][names.index(joint)]
        return position

    def wait_for_joint(self, joint: str, position: float, within: float = 0.02) -> None:
        self.next(
            "state",
            lambda frame: abs(self.position(joint, frame) - position) < within,
        )


@contextmanager
def page_at(url: str, **options: Any) -> Iterator[Page]:
    """Connect as a page at ``url`` would.

    In the end nobody reads any more, so the farewell may not be heard: do not wait.
    """
    options = {"compression": None, "close_timeout": 0.5, **options}
    with connect(socket_url(url), **options) as socket:
        yield Page(socket)
