"""The server's event loop, from the first connection to the end."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Sequence
from typing import Final

from tool0.interfaces.server.backend import Backend
from tool0.interfaces.server.hub import Hub
from tool0.interfaces.server.service import Service

_CHECK_PERIOD: Final = 1.0
"""Wall time between checks for connections that take nothing [s]."""


def run(
    backend: Backend, services: Sequence[Service], name: str, wake: socket.socket
) -> None:
    """Serve until ``wake`` can be read."""
    asyncio.run(_serve(backend, services, name, wake))


async def _serve(
    backend: Backend, services: Sequence[Service], name: str, wake: socket.socket
) -> None:
    wake.setblocking(False)
    stop = asyncio.create_task(_read(wake))
    hub = Hub(backend, name)
    for service in services:
        await service.start(hub)
    while not stop.done():
        await asyncio.wait([stop], timeout=_CHECK_PERIOD)
        hub.drop_stuck()
    for service in services:
        await service.stop()
    await hub.close()
    for service in services:
        await service.end()


async def _read(wake: socket.socket) -> None:
    await asyncio.get_running_loop().sock_recv(wake, 1)
