"""The garbage collector in a process that must not pause: it drives a robot."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

THRESHOLD: Final = 50_000
"""New objects that are not freed, after which those without a user are searched for.

States and motions are freed when nobody uses them.  The interpreter's default, 700, is
reached about once a second of a stream at 500 Hz, and looking at all that is in use
then pauses every thread for 5 to 20 ms.
"""


@contextmanager
def starting() -> Iterator[None]:
    """Collect nothing while a process starts, and restore everything at its end.

    What is made at the start lives on.  Call ``started`` when it is complete.
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
    """Exempt all present objects for good, and collect rarely from now on."""
    gc.freeze()
    gc.set_threshold(THRESHOLD)
    gc.enable()


def leave_alone() -> None:
    """Collect once, and exempt all present objects, in a program that uses tool0.

    With its libraries, a collection of everything would pause each thread for 0.1 s or
    more.
    """
    gc.collect()
    gc.freeze()
