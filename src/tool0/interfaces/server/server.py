"""The server: a thread that serves a robot to all connections.

asyncio and what needs it are imported when the first peer connects: a bring-up that
nobody talks to starts without them.
"""

from __future__ import annotations

import contextlib
import logging
import selectors
import socket
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, final

from tool0.errors import TransportError

if TYPE_CHECKING:
    import asyncio

    from tool0.api.address import Claim
    from tool0.interfaces.server.backend import Backend
    from tool0.interfaces.server.hub import Hub, Service

logger = logging.getLogger(__name__)

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
        if self._server is not None:
            self._server.close()

    async def end(self) -> None:
        """Do nothing: the hub has closed the connections."""

    def release(self) -> None:
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


_CLOSES_WITHIN: Final = 5.0
"""[wall s]"""


@final
class Server(contextlib.AbstractContextManager["Server"]):
    """Serves a robot from construction to ``close``."""

    def __init__(
        self, backend: Backend, services: Sequence[Service], name: str = ""
    ) -> None:
        """Begin to serve at the services' addresses; ``name`` is the bring-up's."""
        self._backend = backend
        self._services = tuple(services)
        self._name = name
        self._wake, self._waker = socket.socketpair()
        self._thread = threading.Thread(
            target=self._run, name="tool0-server", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Close every connection and end; closing twice is allowed."""
        if self._waker.fileno() < 0:
            return
        with contextlib.suppress(OSError):  # the server has failed
            self._waker.send(b"x")
        self._thread.join(_CLOSES_WITHIN)
        self._waker.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            if self._is_needed():
                import asyncio

                from tool0.interfaces.server.hub import serve

                asyncio.run(
                    serve(self._backend, self._services, self._name, self._wake)
                )
        except Exception:  # the robot runs on without its server
            logger.exception("the server failed")
        finally:
            for service in self._services:
                service.release()
            self._wake.close()

    def _is_needed(self) -> bool:
        """Wait for the first peer; return False if the server is closed before."""
        if any(service.starts_at_once for service in self._services):
            return True
        with selectors.DefaultSelector() as selector:
            selector.register(self._wake, selectors.EVENT_READ)
            for service in self._services:
                selector.register(service.listener, selectors.EVENT_READ)
            ready = [key.fileobj for key, _ in selector.select()]
        return self._wake not in ready
