"""Waits with an end, which say what never came."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

LONGEST = 60.0
"""For anything, on a busy machine [wall s]."""
PERIOD = 0.02
"""Between two looks [wall s]."""
Found = TypeVar("Found")


def until(
    condition: Callable[[], Found],
    what: str | Callable[[], str],
    timeout: float = LONGEST,
    *,
    period: float = PERIOD,
) -> Found:
    """Return the first true result of ``condition``; fail if there is none in time.

    Args:
        condition: Looked at again and again.
        what: It waits for; a function tells it at the end.
        timeout: The longest wait [wall s].
        period: Between two looks [wall s]; 0 where ``condition`` itself waits, for a
            packet or an answer.
    """
    deadline = time.monotonic() + timeout
    while not (answer := condition()):
        if time.monotonic() >= deadline:
            told = what if isinstance(what, str) else what()
            raise AssertionError(f"{told}: not within {timeout:g} s")
        time.sleep(period)
    return answer
