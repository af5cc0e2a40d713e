"""The server: a thread that serves a robot to all connections.

asyncio and what needs it are imported when the first peer connects: a bring-up that
nobody talks to starts without them.
"""

from __future__ import annotations

import logging
import selectors
import socket
import threading
from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Final, final

if TYPE_CHECKING:
    from tool0.interfaces.server.backend import Backend
    from tool0.interfaces.server.hub import Service

logger = logging.getLogger(__name__)

_CLOSES_WITHIN: Final = 5.0
"""[wall s]"""


@final
class Server(AbstractContextManager["Server"]):
    """Serves a robot from construction to ``close``."""

    def __init__(
        self, backend: Backend, services: Sequence[Service], name: str = ""
    ) -> None:
        """Begin to serve.

        Args:
            backend: What answers requests.
            services: The addresses where it accepts connections.
            name: Of the bring-up.
        """
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
        self._waker.send(b"x")
        self._thread.join(_CLOSES_WITHIN)
        self._waker.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            if self._is_needed():
                from tool0.interfaces.server.hub import run

                run(self._backend, self._services, self._name, self._wake)
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
