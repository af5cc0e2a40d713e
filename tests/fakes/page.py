"""A page without a browser, which speaks the panel's protocol."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit, urlunsplit

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

PATIENCE = 30.0
"""Longest wait for anything [wall s]."""

Message = dict[str, Any]


def socket_url(url: str) -> str:
    """Return the address of the WebSocket of the page at ``url``."""
    parts = urlsplit(url)
    return urlunsplit(("ws", parts.netloc, "/ws", parts.query, ""))


class Page:
    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self._number = 0
        self._kept: list[Message] = []
        self._newest: dict[str, Message] = {}
        self.hello = self.next("hello")

    def receive(self, deadline: float) -> Message:
        text = self.socket.recv(max(0.0, deadline - time.monotonic()))
        message: Message = json.loads(text)
        self._newest[message["type"]] = message
        return message

    def next(
        self, kind: str, which: Callable[[Message], bool] = lambda _: True
    ) -> Message:
        """Return the next message of a kind of which ``which`` is true.

        Notices and replies that come meanwhile are kept for later.
        """
        for message in self._kept:
            if message["type"] == kind and which(message):
                self._kept.remove(message)
                return message
        deadline = time.monotonic() + PATIENCE
        while True:
            message = self.receive(deadline)
            if message["type"] == kind and which(message):
                return message
            if message["type"] in ("notice", "reply"):
                self._kept.append(message)

    def see(self, kind: str, which: Callable[[Message], bool]) -> Message:
        """Return the newest frame or status as soon as ``which`` is true of it."""
        newest = self._newest.get(kind)
        if newest is not None and which(newest):
            return newest
        return self.next(kind, which)

    def close_code(self) -> int:
        """Read until the server ends the connection, and return the code it gave."""
        try:
            while True:
                self.socket.recv(PATIENCE)
        except ConnectionClosed as closed:
            return 0 if closed.rcvd is None else closed.rcvd.code

    def send(self, kind: str, **fields: Any) -> None:
        self.socket.send(json.dumps({"type": kind, **fields}))

    def ask(self, kind: str, **fields: Any) -> Message | None:
        """Send a request, wait for its answer, and return why it was refused."""
        self._number += 1
        number = self._number
        self.send(kind, id=number, **fields)
        reply = self.next("reply", lambda message: message["id"] == number)
        error: Message | None = reply.get("error")
        return error

    def position(self, joint: str, frame: Message) -> float:
        """Return where a joint is in a frame."""
        names = [item["name"] for item in self.hello["robot"]["joints"]]
        position: float = frame["position"][names.index(joint)]
        return position

    def wait_for_joint(self, joint: str, position: float, within: float = 0.02) -> None:
        self.next(
            "frame",
            lambda frame: abs(self.position(joint, frame) - position) < within,
        )


@contextmanager
def page_at(url: str, **options: Any) -> Iterator[Page]:
    """Connect as a page at ``url`` would."""
    with connect(socket_url(url), compression=None, **options) as socket:
        yield Page(socket)
