"""One connection: its send queue, and its rate limit."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any, Final, Protocol, final

from tool0.errors import TransportError
from tool0.requests.codec import RequestReadError, decode_request, encode_error
from tool0.requests.table import Request

logger = logging.getLogger(__name__)

MAX_QUEUE: Final = 256
"""Replies and events that may wait for a page that reads slowly."""
MAX_SNAPSHOTS: Final = 1024
"""Snapshots that may wait for a slow reader, before it loses the oldest."""
STUCK_AFTER: Final = 10.0
"""Wall time after which a connection that does not read is dropped [s]."""
RATE: Final = 200.0
"""Messages that a page may send per second in the long run; sliders send 30."""
BURST: Final = 1000.0
"""Messages that it may send in one burst."""
_CHUNK: Final = 4096
"""Bytes that count as one message."""
MAX_BACKLOG: Final = 4096
"""Requests of one connection that may wait for each other, in chunks: 16 MiB.  Further
ones are rejected, so that an emergency stop behind them is always read."""
MAX_LINE: Final = 1 << 23
"""Longest request [bytes]; 10 000 points of 6 joints with velocities and accelerations
fit."""

_TOO_MANY: Final = TransportError(
    "too many requests of this connection wait already; wait for replies"
)

Ident = int | str | None
TakeAtOnce = Callable[["Session", Ident, Request[Any]], bool]
"""Takes a request that need not wait for others; returns whether it did."""
CarryOut = Callable[["Session", Ident, Request[Any]], Awaitable[None]]
"""Carries out the other requests, one after the other."""


class Transport(Protocol):
    """Carries text to and from one peer."""

    @property
    def is_trusted(self) -> bool:
        """Whether the peer is a program of this user, which has no rate limit."""

    async def send(self, text: bytes) -> None:
        """Send one message; ConnectionError if the peer has disconnected."""

    async def receive(self) -> bytes | str | None:
        """Return the next message; None if the peer has disconnected.

        Raises:
            TransportError: If it is too long to be read; the stream may be lost then.
        """

    async def close(self) -> None:
        """Close the connection in order."""

    def abort(self) -> None:
        """End the connection at once."""


@final
class Session:
    """Sends at the reader's pace, so that no other connection has to wait."""

    def __init__(
        self, transport: Transport, take_at_once: TakeAtOnce, carry_out: CarryOut
    ) -> None:
        self._transport = transport
        self._take_at_once = take_at_once
        self._carry_out = carry_out
        self._wake = asyncio.Event()
        self._queue: deque[bytes] = deque()
        self._snapshots: deque[bytes] = deque()
        self.missed = 0
        """Snapshots that were dropped since the last one that was queued."""
        self.arms: dict[str, str] = {}
        """The arms that it has taken, and the program that it named."""
        self._latest: dict[str, bytes] = {}
        self._waiting: asyncio.Queue[tuple[int, Ident, Request[Any]] | None]
        self._waiting = asyncio.Queue()
        self._backlog = 0
        """Chunks of the requests that wait or are carried out."""
        self._loop = asyncio.get_running_loop()
        self._allowance = BURST
        self._allowance_at = self._loop.time()
        self._sending_since: float | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self._is_gone = False
        """Whether it can neither send nor receive any more."""

    @property
    def is_busy(self) -> bool:
        """Whether requests wait or are carried out; later ones must not overtake."""
        return self._backlog > 0

    def is_stuck(self) -> bool:
        """Return whether it has not read for too long."""
        since = self._sending_since
        return since is not None and self._loop.time() - since > STUCK_AFTER

    def send(self, text: bytes) -> None:
        """Send ``text`` after what waits; a page with too much waiting is dropped."""
        if len(self._queue) >= MAX_QUEUE and not self._transport.is_trusted:
            self.drop()
            return
        self._queue.append(text)
        self._wake.set()

    def send_snapshot(self, text: bytes) -> None:
        """Send a snapshot of a stream; a slow reader loses the oldest ones."""
        if len(self._snapshots) >= MAX_SNAPSHOTS:
            self._snapshots.popleft()
            self.missed += 1
        self._snapshots.append(text)
        self._wake.set()

    def send_latest(self, kind: str, text: bytes) -> None:
        """Send ``text`` in place of an older one of its kind that was not sent yet."""
        self._latest[kind] = text
        self._wake.set()

    def drop(self) -> None:
        """End the connection at once."""
        self._transport.abort()
        self.end()

    def end(self) -> None:
        """Send and read nothing more."""
        for task in self._tasks:
            task.cancel()

    async def close(self) -> None:
        """Close the connection in order."""
        self.end()
        await self._transport.close()

    async def serve(self) -> None:
        """Send and receive until the connection ends and its requests are answered."""
        worker = asyncio.create_task(self._work())
        parts = (self._write(), self._read())
        self._tasks = [worker, *map(asyncio.create_task, parts)]
        try:
            await asyncio.wait([worker])
        finally:
            self.end()
            ends = await asyncio.gather(*self._tasks, return_exceptions=True)
        for end in ends:
            if isinstance(end, Exception):
                logger.error("a connection failed", exc_info=end)

    async def _write(self) -> None:
        try:
            while True:
                await self._wake.wait()
                self._wake.clear()
                while (text := self._next()) is not None:
                    self._sending_since = self._loop.time()
                    await self._transport.send(text)
                    self._sending_since = None
        except ConnectionError:
            self._is_gone = True

    def _next(self) -> bytes | None:
        if self._queue:
            return self._queue.popleft()
        if self._snapshots:
            return self._snapshots.popleft()
        if self._latest:
            return self._latest.pop(next(iter(self._latest)))
        return None

    async def _read(self) -> None:
        try:
            await self._read_all()
        except TransportError as error:
            self.send(encode_error(None, error))
        except ConnectionError:
            pass  # the peer has disconnected
        except Exception:
            logger.exception("a connection failed")
        self._is_gone = True
        self._waiting.put_nowait(None)

    async def _read_all(self) -> None:
        while (text := await self._transport.receive()) is not None:
            n_chunks = 1 + len(text) // _CHUNK
            if not self._transport.is_trusted:
                # Meanwhile nothing is read, so TCP flow control slows the page down.
                await self._pace(n_chunks)
            try:
                ident, request = decode_request(text)
            except RequestReadError as error:
                self.send(encode_error(error.ident, error.error))
                continue
            if self._take_at_once(self, ident, request):
                continue
            if self._backlog + n_chunks > MAX_BACKLOG:
                self.send(encode_error(ident, _TOO_MANY))
                continue
            self._backlog += n_chunks
            self._waiting.put_nowait((n_chunks, ident, request))

    async def _pace(self, cost: int) -> None:
        """Wait until the page may send ``cost`` more messages."""
        now = self._loop.time()
        gained = (now - self._allowance_at) * RATE
        self._allowance = min(BURST, self._allowance + gained) - cost
        self._allowance_at = now
        if self._allowance < 0.0 and not self._is_gone:
            await asyncio.sleep(-self._allowance / RATE)

    async def _work(self) -> None:
        while (item := await self._waiting.get()) is not None:
            n_chunks, ident, request = item
            await self._carry_out(self, ident, request)
            self._backlog -= n_chunks


@final
class LineTransport:
    """Lines of JSON over the Unix socket."""

    is_trusted: Final = True

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self._reader = reader
        self._writer = writer

    async def send(self, text: bytes) -> None:
        self._writer.write(text + b"\n")
        await self._writer.drain()

    async def receive(self) -> bytes | None:
        while True:
            try:
                line = await self._reader.readuntil(b"\n")
            except asyncio.IncompleteReadError:
                return None
            except asyncio.LimitOverrunError:
                raise TransportError(
                    f"a line is longer than {MAX_LINE} bytes; send fewer waypoints"
                ) from None
            if line.strip():
                return line

    async def close(self) -> None:
        self._writer.close()

    def abort(self) -> None:
        self._writer.transport.abort()
