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

MAX_PEERS: Final = 256


@final
class UnixSocketService:
    """Serves a hub under a claimed name."""

    starts_at_once: Final = False

    def __init__(self, claim: Claim) -> None:
        """Listen: peers wait until the server takes them.

        Raises:
            TransportError: If the socket cannot be made.
        """
        self._claim = claim
        self.listener = _listen(claim)
        self._server: asyncio.Server | None = None

    async def start(self, hub: Hub) -> None:
        """Accept peers."""
        import asyncio

        from tool0.interfaces.server.session import MAX_LINE, LineTransport

        async def serve(
            reader: asyncio.StreamReader, writer: asyncio.StreamWriter
        ) -> None:
            if len(hub.sessions) < MAX_PEERS:
                await hub.serve(LineTransport(reader, writer))
            writer.close()
            with contextlib.suppress(OSError):  # the peer was faster
                await writer.wait_closed()

        self._server = await asyncio.start_unix_server(
            serve, sock=self.listener, limit=MAX_LINE
        )

    async def stop(self) -> None:
        """Stop to accept peers."""
        if self._server is not None:
            self._server.close()

    async def end(self) -> None:
        """Do nothing: the hub has closed the connections."""

    def release(self) -> None:
        """Remove the socket file."""
        self.listener.close()
        self._claim.close()


def _listen(claim: Claim) -> socket.socket:
    """Return a listening socket that only this user can open."""
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        # The folder is 0700 already, so no other user can connect before the chmod.
        listener.bind(str(claim.path))
        claim.path.chmod(0o600)
        listener.listen(16)
        listener.setblocking(False)
    except OSError as error:
        listener.close()
        raise TransportError(f"cannot listen on {claim.path}: {error}") from None
    return listener
