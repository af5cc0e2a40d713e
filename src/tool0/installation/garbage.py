"""Tunes the garbage collector in processes that drive a robot and must not pause."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

THRESHOLD: Final = 50_000
"""Number of unfreed new objects at which the collector searches for cycles.

States and motions are freed when their last reference is deleted.  A stream at 500 Hz
reaches the interpreter's default threshold of 700 objects about once a second.  The
collector then examines all objects in use, and pauses every thread for 5 to 20 ms.
"""


@contextmanager
def starting() -> Iterator[None]:
    """Disable collection while a process starts.

    Restore all settings when the process ends.

    Objects that are created during the start are kept.  Call ``started`` when the start
    is complete.
    """
    usual = gc.get_threshold()
    gc.disable()
    try:
        yield
    finally:
        gc.unfreeze()
        gc.set_threshold(*usual)
        gc.enable()


def started() -> None:
    """Permanently exempt existing objects from collection, and then collect rarely."""
    gc.freeze()
    gc.set_threshold(THRESHOLD)
    gc.enable()


def leave_alone() -> None:
    """Collect once, then exempt all existing objects from collection.

    Use this function in a program that uses tool0.

    With the program's libraries, a full collection would pause every thread for 0.1 s
    or more.
    """
    gc.collect()
    gc.freeze()
