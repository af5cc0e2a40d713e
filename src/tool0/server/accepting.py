"""Accepts connections, even while the process is short of file descriptors.

asyncio's servers would log hundreds of failures at once, and retry after each of them.
"""

from __future__ import annotations

import asyncio
import logging
import math
import socket
from collections.abc import Awaitable, Callable
from typing import Final

logger = logging.getLogger(__name__)

RETRY_AFTER: Final = 1.0
"""Wall time between two attempts while accepting fails [s]."""


async def accept_forever(
    listener: socket.socket, take: Callable[[socket.socket], Awaitable[None]]
) -> None:
    """Accept connections and pass each to ``take``, which then owns it.

    A failure is logged only once until accepting succeeds again.
    """
    loop = asyncio.get_running_loop()
    has_failed = False
    while True:
        try:
            peer, _ = await loop.sock_accept(listener)
        except ConnectionError:
            continue  # the peer has disconnected already
        except OSError as error:
            if not has_failed:
                logger.warning("cannot accept connections: %s", error.strerror)
            has_failed = True
            await asyncio.sleep(RETRY_AFTER)
            continue
        has_failed = False
        try:
            await take(peer)
        except Exception:
            logger.exception("a connection failed")
            peer.close()
        await asyncio.sleep(0)  # many peers at once must not delay the others


def descriptor_limit() -> float:
    """Return the largest number of file descriptors that this process may have."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return math.inf
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return math.inf if soft == resource.RLIM_INFINITY else soft
