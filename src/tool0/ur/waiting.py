"""Waits of programs for other programs, with a limit of wall time."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any, TypeVar

T = TypeVar("T")


async def within(action: Coroutine[Any, Any, T], timeout: float | None) -> T | None:
    """Return the result of an action; None if it is not done in time [wall s].

    Whoever waits here can be cancelled at any moment.  Before Python 3.12,
    asyncio.wait_for drops a cancellation that comes together with the result.
    """
    task = asyncio.ensure_future(action)
    task.add_done_callback(seen)
    try:
        await asyncio.wait({task}, timeout=timeout)
    finally:
        if not task.done():
            task.cancel()
    return task.result() if task.done() else None


def seen(task: asyncio.Future[Any]) -> None:
    """Take the error of an action that nobody waits for any more."""
    if not task.cancelled():
        task.exception()
