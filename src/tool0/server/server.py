"""The server: a thread that serves a robot to all connections.

The module asyncio, and the modules that use it, are imported when the first peer
connects, so a bring-up without peers starts faster.
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
from tool0.protocol.address import is_foreign
from tool0.protocol.fork_guard import OwnProcess

if TYPE_CHECKING:
    import asyncio

    from tool0.protocol.address import Claim
    from tool0.protocol.backend import Backend
    from tool0.server.hub import Hub, Service

logger = logging.getLogger(__name__)

MAX_PEERS: Final = 256


@final
class UnixSocketService:
    """Service for a hub at a claimed name."""

    starts_at_once: Final = False

    def __init__(self, claim: Claim) -> None:
        """Start listening; peers have to wait until the server accepts them.

        Raises:
            TransportError: If the socket cannot be created.
        """
        self._claim = claim
        self.listener = _listen(claim)
        self._accepting: asyncio.Task[None] | None = None

    async def start(self, hub: Hub) -> None:
        import asyncio

        from tool0.server.accepting import accept_forever

        serving: set[asyncio.Task[None]] = set()

        async def take(peer: socket.socket) -> None:
            if is_foreign(peer):
                logger.warning("rejected a program of another user")
                peer.close()
                return
            task = asyncio.create_task(_serve(hub, peer, len(serving) < MAX_PEERS))
            serving.add(task)
            task.add_done_callback(serving.discard)

        self._accepting = asyncio.create_task(accept_forever(self.listener, take))

    async def stop(self) -> None:
        if self._accepting is not None:
            self._accepting.cancel()

    async def end(self) -> None:
        """Do nothing, because the hub has closed the connections."""

    def release(self) -> None:
        self.listener.close()
        self._claim.close()


async def _serve(hub: Hub, peer: socket.socket, has_room: bool) -> None:
    """Serve a program until it disconnects, or reject it unless ``has_room``."""
    import asyncio

    from tool0.protocol.codec import encode_error
    from tool0.server.lines import LineTransport

    lines = LineTransport(hub.budget.account())
    loop = asyncio.get_running_loop()
    await loop.connect_accepted_socket(lambda: lines, peer)
    if has_room:
        await hub.serve(lines)
    else:
        text = f"{MAX_PEERS} programs are connected already; close one"
        with contextlib.suppress(OSError):  # the peer has disconnected
            await lines.send([encode_error(None, TransportError(text))])
    await lines.close()
    await lines.closed()


def _listen(claim: Claim) -> socket.socket:
    """Return a listening socket that only this user can open."""
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        # The folder has the mode 0700, so no other user can connect before the chmod
        # call.
        listener.bind(str(claim.path))
        claim.path.chmod(0o600)
        listener.listen(16)
        listener.setblocking(False)
    except OSError as error:
        listener.close()
        raise TransportError(f"cannot listen on {claim.path}: {error}") from None
    return listener


_CLOSES_WITHIN: Final = 5.0
"""Longest wait for the end of the server's thread [wall s]."""


@final
class Server(contextlib.AbstractContextManager["Server"]):
    """Server of a robot, which runs from its construction until ``close``."""

    def __init__(
        self, backend: Backend, services: Sequence[Service], name: str = ""
    ) -> None:
        """Start serving at the addresses of the services.

        ``name`` names the bring-up.
        """
        self._backend = backend
        self._services = tuple(services)
        self._name = name
        self._process = OwnProcess()
        self._wake, self._waker = socket.socketpair()
        self._thread = threading.Thread(
            target=self._run, name="tool0-server", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Close every connection and end; the server may be closed more than once."""
        if self._waker.fileno() < 0 or not self._process.is_this:
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

                from tool0.server.hub import serve

                asyncio.run(
                    serve(self._backend, self._services, self._name, self._wake)
                )
        except OSError as error:  # the robot keeps running without its server
            logger.error("the server failed: %s", error)  # noqa: TRY400  # not a bug
        except Exception:
            logger.exception("the server failed")
        finally:
            for service in self._services:
                service.release()
            self._wake.close()

    def _is_needed(self) -> bool:
        """Wait for the first peer; return False if the server is closed first."""
        if any(service.starts_at_once for service in self._services):
            return True
        with selectors.DefaultSelector() as selector:
            selector.register(self._wake, selectors.EVENT_READ)
            for service in self._services:
                selector.register(service.listener, selectors.EVENT_READ)
            ready = [key.fileobj for key, _ in selector.select()]
        return self._wake not in ready
