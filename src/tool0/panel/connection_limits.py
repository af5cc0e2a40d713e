"""Limits of connections, so that unauthenticated connections never block others.

A *stranger* is a connection without a request that requires the token.  A stranger may
be a page that is loading, or one of thousands of idle connections from an attacker.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Final, final

from tool0.panel.paced_reading import PacedProtocol
from tool0.server.accepting import accept_forever, descriptor_limit
from tool0.server.budget import Account, Budget

if TYPE_CHECKING:
    from starlette.types import Scope

MAX_CONNECTIONS: Final = 128
"""Maximum number of connections.  An additional connection replaces the oldest
stranger."""
RESERVED_DESCRIPTORS: Final = 64
"""Number of file descriptors that are reserved for the Unix socket and the robot, up to
a quarter of the descriptor limit."""
IDLE_AFTER: Final = 10.0
"""Wall time within which a connection must send a complete header [s]."""
_CHECK_PERIOD: Final = 1.0
"""Period of the checks for idle connections [wall s]."""


@final
class Visitor:
    """One connection, which is stored in the ASGI scope of its requests."""

    transport: asyncio.Transport

    def __init__(self, peer: socket.socket, account: Account) -> None:
        self._socket = peer
        self.account = account
        self.is_stranger = True
        self._n_requests = 0
        self._idle_since = asyncio.get_running_loop().time()

    @staticmethod
    def of(scope: Scope) -> Visitor:
        """Return the connection of a request."""
        visitor: Visitor = scope["state"]["visitor"]
        return visitor

    @property
    def is_open(self) -> bool:
        return self._socket.fileno() >= 0

    @property
    def is_answered(self) -> bool:
        """Whether a request of this connection is being answered."""
        return self._n_requests > 0

    @contextlib.contextmanager
    def answered(self) -> Iterator[None]:
        """Mark a request as being answered."""
        self._n_requests += 1
        try:
            yield
        finally:
            self._n_requests -= 1
            self._idle_since = asyncio.get_running_loop().time()

    def is_idle(self) -> bool:
        """Return whether the connection was idle for longer than ``IDLE_AFTER``."""
        age = asyncio.get_running_loop().time() - self._idle_since
        is_read = not self.transport.get_write_buffer_size()
        return not self.is_answered and is_read and age > IDLE_AFTER

    def drop(self) -> None:
        """End the connection immediately."""
        self.transport.abort()


@final
class Entrance:
    """Acceptor of connections, which drops idle connections."""

    def __init__(
        self,
        listener: socket.socket,
        make_protocol: Callable[[dict[str, Any]], asyncio.Protocol],
        budget: Budget,
    ) -> None:
        """Start accepting connections in the running event loop.

        Args:
            listener: The listening socket.
            make_protocol: Function that makes a protocol with the given state for its
                ASGI scopes.
            budget: Processor-time budget of all connections.
        """
        self._budget = budget
        self._make_protocol = make_protocol
        self._visitors: list[Visitor] = []
        limit = descriptor_limit()
        self._max_descriptors = limit - min(RESERVED_DESCRIPTORS, limit // 4)
        self._tasks = [
            asyncio.create_task(accept_forever(listener, self._take)),
            asyncio.create_task(self._drop_idle()),
        ]

    def close(self) -> None:
        """Stop accepting connections."""
        for task in self._tasks:
            task.cancel()

    async def _take(self, peer: socket.socket) -> None:
        self._visitors = [visitor for visitor in self._visitors if visitor.is_open]
        # The system assigns the lowest free descriptor, so its number shows how many
        # are in use.
        is_short = peer.fileno() >= self._max_descriptors
        is_full = len(self._visitors) >= MAX_CONNECTIONS
        if (is_short or is_full) and not self._drop_a_stranger():
            peer.close()
            return
        visitor = Visitor(peer, self._budget.account())
        inner = self._make_protocol({"visitor": visitor})
        protocol = PacedProtocol(visitor.account, inner)
        loop = asyncio.get_running_loop()
        transport, _ = await loop.connect_accepted_socket(lambda: protocol, peer)
        visitor.transport = transport
        self._visitors.append(visitor)

    def _drop_a_stranger(self) -> bool:
        """Drop the oldest stranger, preferably an idle one.

        Return whether there was a stranger.
        """
        strangers = [visitor for visitor in self._visitors if visitor.is_stranger]
        if not strangers:
            return False
        stranger = min(strangers, key=lambda visitor: visitor.is_answered)
        self._visitors.remove(stranger)
        stranger.drop()
        return True

    async def _drop_idle(self) -> None:
        while True:
            await asyncio.sleep(_CHECK_PERIOD)
            for visitor in self._visitors:
                if visitor.is_open and visitor.is_idle():
                    visitor.drop()
