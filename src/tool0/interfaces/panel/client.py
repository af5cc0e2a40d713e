"""One page: what waits to be sent to it, and how fast it may ask."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Final, final

from starlette.websockets import WebSocket, WebSocketDisconnect

from tool0.interfaces.panel.protocol import ClientMessage, EmergencyStop
from tool0.interfaces.panel.wire import Unreadable, decode

logger = logging.getLogger(__name__)

QUEUE: Final = 256
"""Replies and notices that may wait for a page that reads slowly."""
STUCK_AFTER: Final = 10.0
"""Wall time after which a page that takes nothing is given up [s]."""
RATE: Final = 200.0
"""Messages that a page may send per second in the long run; sliders send 30."""
BURST: Final = 1000.0
"""Messages that it may send at once."""
_CHUNK: Final = 4096
"""Characters that count as one message."""
_ASKED: Final = 64
"""Requests of one page that may wait for each other."""

Receiver = Callable[["Client", ClientMessage | Unreadable], Awaitable[None]]
Urgent = Callable[["Client", ClientMessage], None]


@final
class Client:
    """Sends what is newest, in its own time; nobody waits for it."""

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket
        self._wake = asyncio.Event()
        self._queue: deque[str] = deque()
        self._scene: str | None = None
        self._status: str | None = None
        self._frame: str | None = None
        self._asked: asyncio.Queue[ClientMessage | Unreadable | None]
        self._asked = asyncio.Queue(_ASKED)
        self._loop = asyncio.get_running_loop()
        self._allowance = BURST
        self._allowance_at = self._loop.time()
        self._sending_since: float | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self._is_gone = False
        """Whether it can neither send nor receive any more."""
        self.is_lost = False
        """Whether it was given up: its connection is to be cut, not closed."""

    def is_stuck(self) -> bool:
        """Return whether it has taken nothing for too long."""
        since = self._sending_since
        return since is not None and self._loop.time() - since > STUCK_AFTER

    def tell(self, text: str) -> None:
        """Send ``text`` after what waits; a page with too much waiting is given up."""
        if len(self._queue) >= QUEUE:
            self.give_up()
            return
        self._queue.append(text)
        self._wake.set()

    def show(
        self,
        *,
        scene: str | None = None,
        status: str | None = None,
        frame: str | None = None,
    ) -> None:
        """Send these in the place of older ones that were not sent yet."""
        self._scene = scene or self._scene
        self._status = status or self._status
        self._frame = frame or self._frame
        self._wake.set()

    def give_up(self) -> None:
        """End the connection without a word."""
        self.is_lost = True
        self.end()

    def end(self) -> None:
        """Send and read nothing more."""
        for task in self._tasks:
            task.cancel()

    async def serve(self, urgent: Urgent, in_turn: Receiver) -> None:
        """Send and receive until the connection ends, and what was asked is done.

        Args:
            urgent: Is given each message that must wait for no other.
            in_turn: Is given the others, one after the other.
        """
        worker = asyncio.create_task(self._work(in_turn))
        parts = (self._send(), self._read(urgent))
        self._tasks = [worker, *map(asyncio.create_task, parts)]
        try:
            await asyncio.wait([worker])
        finally:
            self.end()
            ends = await asyncio.gather(*self._tasks, return_exceptions=True)
        for end in ends:
            if isinstance(end, Exception):
                logger.error("a page's connection failed", exc_info=end)

    async def _send(self) -> None:
        try:
            while True:
                await self._wake.wait()
                self._wake.clear()
                while (text := self._next()) is not None:
                    self._sending_since = self._loop.time()
                    await self._socket.send_text(text)
                    self._sending_since = None
        except WebSocketDisconnect:
            self._is_gone = True

    def _next(self) -> str | None:
        if self._queue:
            return self._queue.popleft()
        if self._scene is not None:
            text, self._scene = self._scene, None
            return text
        if self._status is not None:
            text, self._status = self._status, None
            return text
        frame, self._frame = self._frame, None
        return frame

    async def _read(self, urgent: Urgent) -> None:
        try:
            await self._read_all(urgent)
        except Exception:
            logger.exception("a page's connection failed")
        self._is_gone = True
        await self._asked.put(None)

    async def _read_all(self, urgent: Urgent) -> None:
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            text: str | None = event.get("text")
            # Meanwhile nothing is read, and TCP makes the page wait.
            await self._pace(1 + len(text or event["bytes"]) // _CHUNK)
            message = decode(text)
            if isinstance(message, EmergencyStop):
                urgent(self, message)
            else:
                await self._asked.put(message)

    async def _pace(self, cost: int) -> None:
        """Wait until the page may have sent ``cost`` messages more."""
        now = self._loop.time()
        gained = (now - self._allowance_at) * RATE
        self._allowance = min(BURST, self._allowance + gained) - cost
        self._allowance_at = now
        if self._allowance < 0.0 and not self._is_gone:
            await asyncio.sleep(-self._allowance / RATE)

    async def _work(self, in_turn: Receiver) -> None:
        while (message := await self._asked.get()) is not None:
            await in_turn(self, message)
