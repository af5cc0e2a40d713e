"""One connection, with its messages and its requests, which are executed in order.

::

    transport ─► is it a stop? ─► texts ─► decode ─► streamed: at once
                    │             (raw)   (as its      │
                    ▼                      account     └► requests, in order ─► hub
                  hub: at once             admits)

A stop request does not wait for earlier messages, because it is detected in the text
when it is received.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import deque
from collections.abc import Awaitable, Callable, Collection, Sequence
from typing import Any, Final, NamedTuple, Protocol, final

from tool0.errors import ControlError, TransportError
from tool0.protocol.codec import (
    RequestReadError,
    decode_request,
    encode_error,
    may_be_urgent,
)
from tool0.protocol.request import Request, method_name
from tool0.server.budget import Account
from tool0.server.peer_files import PeerFiles

logger = logging.getLogger(__name__)

MAX_QUEUE: Final = 256
"""Largest number of replies and events that may be queued for a page that reads
slowly."""
MAX_UNREAD: Final = 1 << 24
"""Size of a program's queued replies from which its requests are no longer decoded
[bytes]."""
MAX_SNAPSHOTS: Final = 1024
"""Maximum number of snapshots queued for a slow reader; older ones are dropped."""
STUCK_AFTER: Final = 10.0
"""Wall time after which a connection is dropped if its peer does not read [s]."""
_CHUNK: Final = 4096
"""Size of a chunk of requests [bytes]."""
MAX_TEXTS: Final = 1 << 18
"""Size of undecoded messages from which reading is paused [bytes].  The size includes
``_OVERHEAD`` for each message."""
_OVERHEAD: Final = 64
"""Overhead that is added to the size of each waiting message [bytes]."""
MAX_BACKLOG: Final = 4096
"""Largest size of one connection's waiting requests, in chunks: 16 MiB in total.
Additional requests are rejected, so later messages are always read."""
_SENT_AT_ONCE: Final = 1 << 14
"""Total size of the replies that are combined into one send [bytes].  Replies are
combined because sending takes more processor time than encoding."""
_REPLY_COST: Final = 0.1e-3
"""Processor time of sending a reply [s]."""
_REQUEST_COST: Final = 0.3e-3
"""Processor time of a request in other threads, such as the tick thread, including the
time to wake these threads [s]."""
_OVERTAKEN: Final = ControlError(
    "a stop overtook this request, which would have undone it; send it again"
)

_TOO_MANY: Final = TransportError(
    "too many requests of this connection wait already; wait for replies"
)

Ident = int | str | None
TakeAtOnce = Callable[["Session", Ident, Request[Any]], bool]
"""Function that handles a request without waiting for other requests, if possible, and
returns whether it has handled the request."""
Stop = Callable[["Session", Ident, Request[Any]], None]
"""Function that executes a stop request immediately."""
CarryOut = Callable[["Session", Ident, Request[Any]], Awaitable[None]]
"""Function that executes all other requests, one after the other."""


class Transport(Protocol):
    """Transport of text to and from one peer."""

    @property
    def is_trusted(self) -> bool:
        """Whether the peer is a program of this user, which may read slowly."""

    @property
    def files(self) -> PeerFiles | None:
        """Files that the peer's requests may use; None if they may use all files."""

    @property
    def account(self) -> Account:
        """Account that is charged for the peer's work."""

    async def send(self, texts: Sequence[bytes]) -> None:
        """Send messages; raise ConnectionError if the peer has disconnected."""

    async def receive(self) -> bytes | str | None:
        """Return the next message; None if the peer has disconnected.

        Raises:
            TransportError: If the message is too long to be read, in which case the
                stream may be lost.
        """

    async def close(self) -> None:
        """Close the connection properly."""

    def abort(self) -> None:
        """End the connection immediately."""


class _Waiting(NamedTuple):
    """A request that waits for earlier requests."""

    n_chunks: int
    ident: Ident
    request: Request[Any]


@final
class Session:
    """One connection; a peer that reads slowly does not delay other connections."""

    def __init__(
        self,
        transport: Transport,
        take_at_once: TakeAtOnce,
        carry_out: CarryOut,
        stop: Stop,
    ) -> None:
        self._transport = transport
        self._take_at_once = take_at_once
        self._carry_out = carry_out
        self._stop = stop
        self.account = transport.account
        self.files = transport.files
        self._wake = asyncio.Event()
        self._queue: deque[bytes] = deque()
        self._n_unread = 0
        """Size of the messages in the queue [bytes]."""
        self._was_read = asyncio.Event()
        self._snapshots: deque[bytes] = deque()
        self.missed = 0
        """Number of snapshots that were dropped since the last complete state was
        queued."""
        self.arms: dict[str, str] = {}
        """Name of the controlling program by arm, for the arms that the peer
        controls."""
        self._latest: dict[str, bytes] = {}
        self._texts: deque[bytes | str | None] = deque()
        """Messages that have not been decoded yet; None is the end marker."""
        self._n_texts = 0
        """Size of the undecoded messages [bytes]."""
        self._has_text, self._has_room = asyncio.Event(), asyncio.Event()
        self._waiting: deque[_Waiting | None] = deque()
        """Waiting requests; None is the end marker."""
        self._current: Request[Any] | None = None
        """Request that is being executed."""
        self._has_work = asyncio.Event()
        self._backlog = 0
        """Size of the requests that are waiting or being executed, in chunks."""
        self._loop = asyncio.get_running_loop()
        self._sending_since: float | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self._is_gone = False
        """Whether the peer no longer reads any messages."""

    @property
    def is_busy(self) -> bool:
        """Whether requests are waiting or being executed; new requests then wait."""
        return self._backlog > 0

    def is_stuck(self) -> bool:
        """Return whether the peer has not read messages for too long."""
        since = self._sending_since
        return since is not None and self._loop.time() - since > STUCK_AFTER

    def send(self, text: bytes) -> None:
        """Send ``text`` after all queued messages.

        A page with a full queue is dropped.
        """
        if len(self._queue) >= MAX_QUEUE and not self._transport.is_trusted:
            self.drop()
            return
        self._queue.append(text)
        self._n_unread += len(text)
        self._wake.set()

    def send_snapshot(self, text: bytes) -> None:
        """Send a snapshot of a stream.

        The oldest snapshots are dropped for a slow reader.
        """
        if len(self._snapshots) >= MAX_SNAPSHOTS:
            self._snapshots.popleft()
            self.missed += 1
        self._snapshots.append(text)
        self._wake.set()

    def send_latest(self, kind: str, text: bytes) -> None:
        """Send ``text`` in place of an older unsent text of the same kind."""
        self._latest[kind] = text
        self._wake.set()

    def drop(self) -> None:
        """End the connection immediately."""
        self._transport.abort()
        self.end()

    def end(self) -> None:
        """Stop sending and reading."""
        for task in self._tasks:
            task.cancel()

    async def close(self) -> None:
        """Close the connection properly."""
        self.end()
        await self._transport.close()

    async def serve(self) -> None:
        """Send and receive until the connection ends and its requests are answered."""
        worker = asyncio.create_task(self._work())
        parts = (self._write(), self._read(), self._decode())
        self._tasks = [worker, *map(asyncio.create_task, parts)]
        try:
            await asyncio.wait([worker])
        finally:
            self.end()
            ends = await asyncio.gather(*self._tasks, return_exceptions=True)
        for end in ends:
            if isinstance(end, Exception):
                logger.error("a connection failed", exc_info=end)

    # ---- sending --------------------------------------------------------------------

    async def _write(self) -> None:
        try:
            while True:
                await self._wake.wait()
                self._wake.clear()
                while texts := self._next():
                    self._sending_since = self._loop.time()
                    await self._transport.send(texts)
                    self._sending_since = None
        except ConnectionError:
            self._is_gone = True
            self._was_read.set()

    def _next(self) -> list[bytes]:
        """Return the next texts to send; the result is empty if there are no texts."""
        if self._queue:
            texts, size = [], 0
            while self._queue and size < _SENT_AT_ONCE:
                texts.append(self._queue.popleft())
                size += len(texts[-1])
            self._n_unread -= size
            self._was_read.set()
            return texts
        if self._snapshots:
            return [self._snapshots.popleft()]
        if self._latest:
            return [self._latest.pop(next(iter(self._latest)))]
        return []

    # ---- receiving ------------------------------------------------------------------

    async def _read(self) -> None:
        try:
            await self._read_all()
        except TransportError as error:
            self.send(encode_error(None, error))
        except ConnectionError:
            pass  # the peer has disconnected
        except Exception:
            logger.exception("a connection failed")
        self._texts.append(None)
        self._has_text.set()

    async def _read_all(self) -> None:
        while (text := await self._transport.receive()) is not None:
            with self.account.working():
                self._take(text)
            await self.account.give_way()
            while self._n_texts >= MAX_TEXTS:
                # Reading is paused, so flow control slows down the peer.
                self._has_room.clear()
                await self._has_room.wait()

    def _take(self, text: bytes | str) -> None:
        """Handle a message; a stop is executed before waiting messages are decoded."""
        if may_be_urgent(text) and self._take_stop(text):
            return
        if not self._texts and self._may_decode():
            self._process(text)
            return
        self._texts.append(text)
        self._n_texts += len(text) + _OVERHEAD
        self._has_text.set()

    def _take_stop(self, text: bytes | str) -> bool:
        """Execute a stop; return False if the message is not a stop."""
        try:
            ident, request = decode_request(text, suggests=False)
        except RequestReadError:
            return False  # answered in order
        if not request.is_urgent:
            return False
        self._revoke(request)
        if self._current is not None and _undoes(self._current, request):
            self._waiting.appendleft(_Waiting(1, ident, request))
            self._backlog += 1
            self._has_work.set()
        else:
            self._stop(self, ident, request)
        return True

    def _revoke(self, stop: Request[Any]) -> None:
        """Refuse waiting requests that would undo a stop that overtakes them."""
        methods = stop.revokes
        for text in [text for text in self._texts if _names(text, methods)]:
            assert text is not None  # it contains a method
            with contextlib.suppress(RequestReadError):  # answered in order
                ident, request = decode_request(text, suggests=False)
                if _undoes(request, stop):
                    self._texts.remove(text)
                    self._n_texts -= len(text) + _OVERHEAD
                    self.send(encode_error(ident, _OVERTAKEN))
        for item in [item for item in self._waiting if item is not None]:
            if _undoes(item.request, stop):
                self._waiting.remove(item)
                self._backlog -= item.n_chunks
                self.send(encode_error(item.ident, _OVERTAKEN))

    def _may_decode(self) -> bool:
        return self.account.may_go_on and self._n_unread < MAX_UNREAD

    async def _decode(self) -> None:
        """Decode waiting messages as fast as the account permits and the peer reads."""
        while True:
            await self._has_text.wait()
            self._has_text.clear()
            while self._texts:
                await self.account.admit()
                while self._n_unread >= MAX_UNREAD and not self._is_gone:
                    self._was_read.clear()
                    await self._was_read.wait()
                if not self._texts:
                    break  # the messages were revoked
                text = self._texts.popleft()
                if text is None:
                    self._waiting.append(None)
                    self._has_work.set()
                    return
                self._n_texts -= len(text) + _OVERHEAD
                self._has_room.set()
                with self.account.working():
                    self._process(text)

    def _process(self, text: bytes | str) -> None:
        """Decode a message, and execute or queue its request."""
        self.account.charge(_REPLY_COST)
        try:
            ident, request = decode_request(text, suggests=self.account.has_spare)
        except RequestReadError as error:
            self.send(encode_error(error.ident, error.error))
            return
        if self._take_at_once(self, ident, request):
            return
        n_chunks = _n_chunks(text)
        if self._backlog + n_chunks > MAX_BACKLOG:
            self.send(encode_error(ident, _TOO_MANY))
            return
        self.account.charge(_REQUEST_COST)
        self._backlog += n_chunks
        self._waiting.append(_Waiting(n_chunks, ident, request))
        self._has_work.set()

    async def _work(self) -> None:
        """Execute requests, one after the other."""
        while True:
            await self._has_work.wait()
            self._has_work.clear()
            while self._waiting:
                await self.account.admit()
                if not self._waiting:
                    break  # the requests were revoked
                item = self._waiting.popleft()
                if item is None:
                    return
                self._current = item.request
                await self._carry_out(self, item.ident, item.request)
                self._current = None
                self._backlog -= item.n_chunks


def _n_chunks(text: bytes | str) -> int:
    return 1 + len(text) // _CHUNK


def _names(text: bytes | str | None, methods: Collection[str]) -> bool:
    """Return whether a message contains one of ``methods``."""
    if text is None:
        return False
    if isinstance(text, str):
        return any(method in text for method in methods)
    return any(method.encode() in text for method in methods)


def _undoes(request: Request[Any], stop: Request[Any]) -> bool:
    """Return whether ``request``, sent before ``stop``, would undo ``stop``."""
    if method_name(type(request)) not in stop.revokes:
        return False
    arms = {getattr(request, "arm", None), getattr(stop, "arm", None)}
    return None in arms or len(arms) == 1
