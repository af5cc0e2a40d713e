"""The server: a thread with an event loop, a hub, and the services that feed it."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Final, Protocol, final

from tool0.interfaces.server.backend import Backend
from tool0.interfaces.server.hub import Hub

logger = logging.getLogger(__name__)

_CLOSES_WITHIN: Final = 5.0
"""[wall s]"""
_CHECK_PERIOD: Final = 1.0
"""Wall time between checks for connections that take nothing [s]."""


class Service(Protocol):
    """A way in: it listens from its construction on."""

    async def start(self, hub: Hub) -> None:
        """Take peers, in the server's event loop."""

    async def stop(self) -> None:
        """Take no more peers."""

    def release(self) -> None:
        """Give back what was listening; twice is allowed."""


@final
class Server(AbstractContextManager["Server"]):
    """Serves a robot from construction to ``close``."""

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
        self._loop = asyncio.new_event_loop()
        self._stop = asyncio.Event()
        self._thread = threading.Thread(
            target=self._run, name="tool0-server", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Say goodbye to every peer and end; closing twice is allowed."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join(_CLOSES_WITHIN)

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            self._loop.run_until_complete(self._serve())
        except Exception:  # the robot runs on without its server
            logger.exception("the server failed")
        finally:
            for service in self._services:
                service.release()
            self._loop.run_until_complete(_end_tasks())
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
            self._loop.close()

    async def _serve(self) -> None:
        hub = Hub(self._backend, self._name)
        for service in self._services:
            await service.start(hub)
        while not self._stop.is_set():
            try:
                await asyncio.wait_for(self._stop.wait(), _CHECK_PERIOD)
            except asyncio.TimeoutError:
                hub.drop_stuck()
        for service in self._services:
            await service.stop()
        await hub.close()


async def _end_tasks() -> None:
    """End what is left in the loop, such as a peer that never said goodbye."""
    tasks = asyncio.all_tasks() - {asyncio.current_task()}
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
