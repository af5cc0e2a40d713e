"""Waits of programs for other programs, limited in wall time."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any, TypeVar

T = TypeVar("T")


async def within(action: Coroutine[Any, Any, T], timeout: float | None) -> T | None:
    """Return the result of an action; None if the action exceeds a limit [wall s].

    The wait can be canceled at any time. Before Python 3.12, asyncio.wait_for loses a
    cancellation that coincides with the result.
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
    """Retrieve the error of an action that no task awaits anymore."""
    if not task.cancelled():
        task.exception()
