"""The measured joint state, and selecting joints out of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import NamedTuple


class JointState(NamedTuple):
    """The measured state of every movable joint at one instant.

    Lists have shape (n_joints,), ordered as the engine's ``joint_names``.  A named
    tuple of plain lists: the tick makes one a thousand times a second, and plain
    floats are what Python computes with fastest.
    """

    time: float
    """Simulated time [s]."""
    position: list[float]
    """[rad], or [m] for a prismatic joint."""
    velocity: list[float]
    """[rad/s] or [m/s]."""
    effort: list[float]
    """Last applied effort [N·m] or [N]."""


JointSelector = Callable[[list[float]], Sequence[float]]
"""Takes some joints out of a list of all joints."""


def joint_selector(indices: Sequence[int]) -> JointSelector:
    """Return the function that takes ``indices`` out of a list.

    It runs in C: a slice where the joints stand side by side, as they mostly do.
    """
    run = as_slice(indices)
    if run is not None:
        return itemgetter(run)
    return itemgetter(*indices)


def as_slice(indices: Sequence[int]) -> slice | None:
    """Return the slice that is ``indices``, or None if they do not stand in a row."""
    first = indices[0] if indices else 0
    if list(indices) == list(range(first, first + len(indices))):
        return slice(first, first + len(indices))
    return None
