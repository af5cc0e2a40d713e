"""Lines of JSON over the Unix socket, read only as fast as they are processed."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Final, final

from tool0.errors import TransportError
from tool0.server.budget import Account

MAX_LINE: Final = 1 << 23
"""Largest size of a request, which is sufficient for 10 000 points of 6 joints with
velocities and accelerations [bytes]."""
_CHUNK: Final = 1 << 15
"""Largest number of bytes in one read, and number of buffered bytes at which reading is
paused."""
_READ_COST: Final = 50e-6
"""Processor time of the system calls for one read [s]."""
_arriving: Final = memoryview(bytearray(_CHUNK))
"""Buffer into which the event loop reads data; the data is copied out immediately."""


@final
class LineTransport(asyncio.BufferedProtocol):
    """Connection to one program; see ``session.Transport``."""

    is_trusted: Final = True
    files: Final = None

    def __init__(self, account: Account) -> None:
        self.account = account
        self._transport: asyncio.Transport
        self._buffer = bytearray()
        self._searched = 0
        """Number of bytes at the start of the buffer that do not contain a newline."""
        self._is_paused = False
        self._has_ended = False
        """Whether no more data will be received."""
        self._is_lost = False
        self._arrived, self._is_writable = asyncio.Event(), asyncio.Event()
        self._is_writable.set()

    # ---- interface for asyncio ------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport

    def get_buffer(self, sizehint: int) -> memoryview:
        return _arriving

    def buffer_updated(self, nbytes: int) -> None:
        with self.account.working():
            self._buffer += _arriving[:nbytes]
        self.account.charge(_READ_COST)
        self._arrived.set()
        if len(self._buffer) > _CHUNK and not self._is_paused:
            self._is_paused = True
            self._transport.pause_reading()

    def eof_received(self) -> bool:
        self._has_ended = True
        self._arrived.set()
        return True  # replies can still be sent

    def connection_lost(self, exc: Exception | None) -> None:
        self._has_ended = self._is_lost = True
        self._arrived.set()
        self._is_writable.set()

    def pause_writing(self) -> None:
        self._is_writable.clear()

    def resume_writing(self) -> None:
        self._is_writable.set()

    # ---- interface for a session ----------------------------------------------------

    async def send(self, texts: Sequence[bytes]) -> None:
        # A failed write closes the transport immediately, but asyncio reports the
        # failure later.
        if self._is_lost or self._transport.is_closing():
            raise ConnectionResetError
        self._transport.write(b"\n".join((*texts, b"")))
        await self._is_writable.wait()

    async def receive(self) -> bytes | None:
        while True:
            with self.account.working():
                line = self._take()
            if line is None and self._has_ended:
                return None
            if line is None:
                self._arrived.clear()
                self._read_on()
                await self._arrived.wait()
                if len(self._buffer) > _CHUNK:
                    await self.account.admit()  # charges each part of a long line
            elif line.strip():
                return line
            else:
                await self.account.give_way()

    def _take(self) -> bytes | None:
        """Return the next line; None if the line has not been received completely."""
        end = self._buffer.find(b"\n", self._searched)
        if (len(self._buffer) if end < 0 else end) > MAX_LINE:
            raise TransportError(
                f"a line is longer than {MAX_LINE} bytes; send fewer waypoints"
            )
        if end < 0:
            self._searched = len(self._buffer)
            return None
        line = bytes(self._buffer[:end])
        del self._buffer[: end + 1]
        self._searched = 0
        if len(self._buffer) < _CHUNK:
            self._read_on()
        return line

    async def close(self) -> None:
        self._transport.close()

    def abort(self) -> None:
        self._transport.abort()

    async def closed(self) -> None:
        """Wait until the connection has ended."""
        while not self._is_lost:
            self._arrived.clear()
            await self._arrived.wait()

    def _read_on(self) -> None:
        if self._is_paused and not self._is_lost:
            self._is_paused = False
            self._transport.resume_reading()
