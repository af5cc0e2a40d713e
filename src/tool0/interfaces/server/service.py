"""What a server serves at: an address that accepts connections."""

from __future__ import annotations

import socket
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from tool0.interfaces.server.hub import Hub


class Service(Protocol):
    """Accepts connections at an address; it listens from its construction on."""

    @property
    def listener(self) -> socket.socket: ...

    @property
    def starts_at_once(self) -> bool:
        """Whether to start before the first peer connects."""

    async def start(self, hub: Hub) -> None:
        """Accept peers, in the server's event loop."""

    async def stop(self) -> None:
        """Stop to accept peers; the hub then closes the connections."""

    async def end(self) -> None:
        """End what is left in the event loop."""

    def release(self) -> None:
        """Free the address, also if the service was never started."""
