"""TCP servers that limit the number of clients and each client's unread data."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import socket
from collections.abc import Awaitable, Callable
from typing import Final, final
from weakref import WeakKeyDictionary

from tool0.errors import TransportError
from tool0.server.budget import Budget

logger = logging.getLogger(__name__)

MAX_CLIENTS: Final = 16
"""Maximum number of clients of a port; additional clients are refused."""
REQUEST_COST: Final = 0.1e-3
"""Processor time for answering a line or a frame [s]."""
MAX_OWED: Final = 1 << 20
"""Amount of unread data above which a client is disconnected [bytes]."""


@final
class Peer:
    """A client of a port."""

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self.reader = reader
        self._writer = writer
        self.account = _budget().account()
        """Account that limits the client's use of processor time. All clients share one
        budget, which limits how fast their data is read."""
        self.address = str(writer.get_extra_info("peername"))

    def send(self, data: bytes) -> None:
        """Send data without waiting; a client that does not read is disconnected."""
        transport = self._writer.transport
        if transport.is_closing():
            return
        if transport.get_write_buffer_size() > MAX_OWED:
            logger.warning("%s does not read: it is dropped", self.address)
            transport.abort()
            return
        self._writer.write(data)

    @property
    def owed(self) -> int:
        """Amount of data that the client has not read yet [bytes]."""
        return self._writer.transport.get_write_buffer_size()

    def drop(self) -> None:
        """Close the connection immediately."""
        self._writer.transport.abort()

    async def close(self) -> None:
        """Close the connection after all data has been sent."""
        self._writer.close()
        with contextlib.suppress(OSError):
            await self._writer.wait_closed()


_budgets: WeakKeyDictionary[asyncio.AbstractEventLoop, Budget] = WeakKeyDictionary()


def _budget() -> Budget:
    """Return the budget that the clients of all ports share.

    The budget is strict, because data from clients causes requests to the bring-up,
    which limits the rate at which it reads requests from this process.
    """
    loop = asyncio.get_running_loop()
    if loop not in _budgets:
        _budgets[loop] = Budget(is_strict=True)
    return _budgets[loop]


Serve = Callable[[Peer], Awaitable[None]]
_open_ports: set[Port] = set()
"""Ports on which this process listens."""


def count_clients(host: str) -> int:
    """Return the total number of clients of the ports at an address."""
    return sum(len(port.peers) for port in _open_ports if port.host == host)


@final
class Port:
    """A port on which the process listens for clients and serves them."""

    def __init__(self, name: str, serve: Serve, *, limit: int = 1 << 16) -> None:
        """Prepare a port without opening it.

        Args:
            name: Name of the port in messages, such as ``RTDE``.
            serve: Function that serves one client and returns when the client has
                disconnected.
            limit: Maximum length of a line that a client may send [bytes].
        """
        self.name = name
        self._serve_peer = serve
        self._limit = limit
        self.peers: set[Peer] = set()
        self._server: asyncio.Server | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        self.host, self.number = "", 0
        """Address and number of the port after it has been opened."""

    async def listen(self, host: str, port: int) -> None:
        """Accept clients at an address.

        Raises:
            TransportError: If the port cannot be opened.
        """
        try:
            self._server = await asyncio.start_server(
                self._accept, host, port, limit=self._limit, reuse_address=True
            )
        except OSError as error:
            # asyncio's error text repeats the address
            reason = os.strerror(error.errno) if error.errno else str(error)
            raise TransportError(
                f"cannot listen on {host}:{port} ({self.name}): {reason}; "
                "choose another address (--ur-host) or other ports (--ur-port-base)"
            ) from None
        self.host, self.number = host, self._server.sockets[0].getsockname()[1]
        _open_ports.add(self)

    async def close(self) -> None:
        """Close the port and its connections."""
        _open_ports.discard(self)
        if self._server is not None:
            self._server.close()
        for peer in tuple(self.peers):
            peer.drop()
        if self._tasks:
            await asyncio.wait(self._tasks, timeout=1.0)

    async def _accept(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        peer = Peer(reader, writer)
        if len(self.peers) >= MAX_CLIENTS:
            logger.warning("%s has %d clients already", self.name, MAX_CLIENTS)
            peer.drop()
            return
        connection: socket.socket = writer.get_extra_info("socket")
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        task = asyncio.current_task()
        assert task is not None
        self._tasks.add(task)
        self.peers.add(peer)
        try:
            await self._serve_peer(peer)
        except (OSError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            pass  # the client has disconnected or sent too much
        except ValueError as error:  # raised by readline for a long line
            logger.warning("%s: %s", self.name, error)
        except asyncio.CancelledError:
            pass
        except Exception:  # an error with one client must not end the others
            logger.exception("%s: a client's packet failed", self.name)
        finally:
            self.peers.discard(peer)
            self._tasks.discard(task)
            peer.drop()
