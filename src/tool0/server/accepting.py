"""Accepts connections, even if the process temporarily has no free file descriptors.

The servers of asyncio would log hundreds of failures at the same time, and would retry
after each failure.
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
"""Wall time between two attempts to accept a connection after a failure [s]."""


async def accept_forever(
    listener: socket.socket, take: Callable[[socket.socket], Awaitable[None]]
) -> None:
    """Accept connections and pass each connection to ``take``, which must close it.

    After a failure is logged, further failures are not logged until a connection is
    accepted.
    """
    loop = asyncio.get_running_loop()
    has_failed = False
    while True:
        try:
            peer, _ = await loop.sock_accept(listener)
        except ConnectionError:
            continue  # the peer has disconnected
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
        await asyncio.sleep(0)  # many new peers must not delay other tasks


def descriptor_limit() -> float:
    """Return the largest number of file descriptors that this process may have."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return math.inf
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return math.inf if soft == resource.RLIM_INFINITY else soft
