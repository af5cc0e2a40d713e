"""Taking a controller's joints out of the lists of all joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import itemgetter

Picker = Callable[[list[float]], Sequence[float]]


def picker(indices: Sequence[int]) -> Picker:
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
