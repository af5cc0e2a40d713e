"""The server: a thread with an event loop, a hub, and the services that feed it."""

from __future__ import annotations

import contextlib
import logging
import select
import socket
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, Protocol, final

from tool0.interfaces.server.backend import Backend

if TYPE_CHECKING:
    import asyncio

    from tool0.interfaces.server.hub import Hub

logger = logging.getLogger(__name__)

_CLOSES_WITHIN: Final = 5.0
"""[wall s]"""
_CHECK_PERIOD: Final = 1.0
"""Wall time between checks for connections that take nothing [s]."""


class Service(Protocol):
    """A way in: it listens from its construction on."""

    @property
    def listener(self) -> socket.socket | None:
        """The socket at which the first peer arrives; None to start without one."""

    async def start(self, hub: Hub) -> None:
        """Take peers, in the server's event loop."""

    async def stop(self) -> None:
        """Take no more peers."""

    def release(self) -> None:
        """Give back what was listening; twice is allowed."""


@final
class Server:
    """Serves a robot from construction to ``close``.

    It loads asyncio and the codec, 50 ms, when the first peer arrives: many bring-ups
    have none.
    """

    def __init__(
        self, backend: Backend, services: Sequence[Service], name: str = ""
    ) -> None:
        """Begin to serve.

        Args:
            backend: What answers requests.
            services: The ways in.
            name: Of the bring-up.
        """
        self._backend = backend
        self._services = tuple(services)
        self._name = name
        self._wake, self._waker = socket.socketpair()
        self._is_closing = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stop: asyncio.Event | None = None
        self._thread = threading.Thread(
            target=self._run, name="tool0-server", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Say goodbye to every peer and end; closing twice is allowed."""
        self._is_closing = True
        if self._thread.is_alive():
            with contextlib.suppress(OSError):  # it ends just now
                self._waker.send(b"x")
            if self._loop is not None and self._stop is not None:
                with contextlib.suppress(RuntimeError):  # likewise
                    self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join(_CLOSES_WITHIN)
        self._waker.close()

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            if self._await_peer():
                import asyncio

                asyncio.run(self._serve())
        except Exception:  # the robot runs on without its server
            logger.exception("the server failed")
        finally:
            for service in self._services:
                service.release()
            self._wake.close()

    def _await_peer(self) -> bool:
        """Wait for the first peer; return False if the server is closed before."""
        listeners = [service.listener for service in self._services]
        sockets = [listener for listener in listeners if listener is not None]
        if len(sockets) == len(listeners):
            select.select([*sockets, self._wake], [], [])
        return not self._is_closing

    async def _serve(self) -> None:
        import asyncio

        from tool0.interfaces.server.hub import Hub

        stop = self._stop = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        hub = Hub(self._backend, self._name)
        for service in self._services:
            await service.start(hub)
        while not (stop.is_set() or self._is_closing):
            try:
                await asyncio.wait_for(stop.wait(), _CHECK_PERIOD)
            except asyncio.TimeoutError:
                hub.drop_stuck()
        for service in self._services:
            await service.stop()
        await hub.close()
