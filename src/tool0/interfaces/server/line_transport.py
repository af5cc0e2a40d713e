"""Lines of JSON over the Unix socket, in the server's event loop."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from typing import Final, final

from tool0.interfaces.server.hub import Hub
from tool0.interfaces.server.session import MessageTooLongError

MAX_LINE: Final = 1 << 20
"""Longest request [bytes]; 10 000 waypoints of 6 joints fit."""
MAX_PEERS: Final = 256


async def start(hub: Hub, listener: socket.socket) -> asyncio.Server:
    """Serve the peers that connect to ``listener``."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if len(hub.sessions) < MAX_PEERS:
            await hub.serve(_LineTransport(reader, writer))
        writer.close()
        with contextlib.suppress(OSError):  # the peer was faster
            await writer.wait_closed()

    return await asyncio.start_unix_server(serve, sock=listener, limit=MAX_LINE)


@final
class _LineTransport:
    """One peer; see ``session.Transport``."""

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
                raise MessageTooLongError(
                    f"a line is longer than {MAX_LINE} bytes; send fewer waypoints"
                ) from None
            if line.strip():
                return line

    async def close(self) -> None:
        self._writer.close()

    def abort(self) -> None:
        self._writer.transport.abort()
