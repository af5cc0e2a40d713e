"""The Unix socket: messages are lines of JSON, and peers are this user's programs."""

from __future__ import annotations

import contextlib
import socket
from typing import TYPE_CHECKING, Final, final

from tool0.api.address import Claim
from tool0.errors import TransportError

if TYPE_CHECKING:
    import asyncio

    from tool0.interfaces.server.hub import Hub

MAX_LINE: Final = 1 << 20
"""Longest request [bytes]; 10 000 waypoints of 6 joints fit."""
MAX_PEERS: Final = 256


@final
class UnixSocketService:
    """Serves a hub under a claimed name."""

    def __init__(self, claim: Claim) -> None:
        """Listen: peers wait until the server takes them.

        Raises:
            TransportError: If the socket cannot be made.
        """
        self._claim = claim
        self.listener = _listen(claim)
        self._server: asyncio.Server | None = None

    async def start(self, hub: Hub) -> None:
        """Take peers."""
        import asyncio

        async def serve(
            reader: asyncio.StreamReader, writer: asyncio.StreamWriter
        ) -> None:
            if len(hub.sessions) >= MAX_PEERS:
                writer.close()
                return
            await hub.serve(_LineTransport(reader, writer))
            writer.close()
            with contextlib.suppress(OSError):  # the peer was faster
                await writer.wait_closed()

        self._server = await asyncio.start_unix_server(
            serve, sock=self.listener, limit=MAX_LINE
        )

    async def stop(self) -> None:
        """Take no more peers."""
        if self._server is not None:
            self._server.close()

    def release(self) -> None:
        """Remove the socket file; twice is allowed."""
        self.listener.close()
        self._claim.close()


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
        import asyncio

        from tool0.interfaces.server.session import MessageTooLongError

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


def _listen(claim: Claim) -> socket.socket:
    """Return a listening socket that only this user can open."""
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        # The folder is 0700 already, so nobody can come in before the chmod.
        listener.bind(str(claim.path))
        claim.path.chmod(0o600)
        listener.listen(16)
        listener.setblocking(False)
    except OSError as error:
        listener.close()
        raise TransportError(f"cannot listen on {claim.path}: {error}") from None
    return listener
