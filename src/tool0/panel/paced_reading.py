"""Reads a connection for a uvicorn protocol at the pace that the account allows.

The frames of a WebSocket are parsed immediately after they are read, which takes 20 µs
per frame.  A single read of 256 kB would therefore block the event loop for 100 ms.
"""

from __future__ import annotations

import asyncio
from typing import Any, Final, final

from tool0.server.budget import Account

_CHUNK: Final = 1 << 12
"""Largest number of bytes in one read.  Even if they consist of short frames, they are
parsed within 0.5 ms."""
_arriving: Final = memoryview(bytearray(_CHUNK))
"""Buffer into which the event loop reads data; the data is copied out immediately."""


@final
class PacedProtocol(asyncio.BufferedProtocol):
    """Protocol that passes received data to another protocol at the account's pace."""

    def __init__(self, account: Account, protocol: asyncio.Protocol) -> None:
        self._account = account
        self.protocol = protocol
        """Protocol that receives the data; a WebSocket upgrade replaces the
        protocol."""
        self._transport: asyncio.Transport
        self._is_waiting, self._is_paused = False, False
        """Whether reading has been paused by the account and by the protocol, in this
        order."""
        self._task: asyncio.Task[None] | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        self.protocol.connection_made(_PacedTransport(transport, self))

    def get_buffer(self, sizehint: int) -> memoryview:
        return _arriving

    def buffer_updated(self, nbytes: int) -> None:
        with self._account.working():
            self.protocol.data_received(bytes(_arriving[:nbytes]))
        is_all = nbytes < _CHUNK  # no more data at present
        if not (is_all or self._is_waiting or self._account.may_go_on):
            self._is_waiting = True
            self._update()
            self._task = asyncio.create_task(self._wait())

    def eof_received(self) -> bool | None:
        return self.protocol.eof_received()

    def connection_lost(self, exc: Exception | None) -> None:
        if self._task is not None:
            self._task.cancel()
        self.protocol.connection_lost(exc)

    def pause_writing(self) -> None:
        self.protocol.pause_writing()

    def resume_writing(self) -> None:
        self.protocol.resume_writing()

    def pause(self, paused: bool) -> None:
        """Pause or resume reading on behalf of the protocol."""
        self._is_paused = paused
        self._update()

    async def _wait(self) -> None:
        await self._account.admit()
        self._is_waiting = False
        self._update()

    def _update(self) -> None:
        if self._is_waiting or self._is_paused:
            self._transport.pause_reading()
        else:
            self._transport.resume_reading()


@final
class _PacedTransport(asyncio.Transport):
    """Transport that is passed to uvicorn's protocols."""

    def __init__(self, transport: asyncio.Transport, paced: PacedProtocol) -> None:
        super().__init__()
        self._transport = transport
        self._paced = paced

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return self._transport.get_extra_info(name, default)

    def get_write_buffer_size(self) -> int:
        return self._transport.get_write_buffer_size()

    def is_closing(self) -> bool:
        return self._transport.is_closing()

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self._transport.write(data)

    def close(self) -> None:
        self._transport.close()

    def abort(self) -> None:
        self._transport.abort()

    def set_protocol(self, protocol: asyncio.BaseProtocol) -> None:
        assert isinstance(protocol, asyncio.Protocol)
        self._paced.protocol = protocol

    def pause_reading(self) -> None:
        self._paced.pause(True)

    def resume_reading(self) -> None:
        self._paced.pause(False)
