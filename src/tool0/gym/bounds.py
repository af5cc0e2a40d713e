"""Bounds and column indices of observations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tool0.batch.arguments import are_finite
from tool0.kinematics.chain import Array

FARTHEST = 10.0
"""Largest absolute value of coordinates [m]."""
FASTEST_OBJECT = 20.0
"""Largest velocity of objects [m/s]."""
STRONGEST, MOST_TORQUE = 1000.0, 100.0
"""Largest force [N] and torque [N·m] of wrenches."""


def finite(values: Array) -> Array:
    """Return a copy with finite numbers in place of diverged values."""
    if are_finite(values):
        return values.copy()
    return np.nan_to_num(values, nan=0.0, posinf=FARTHEST, neginf=-FARTHEST)


def reading(diverged: NDArray[np.bool_]) -> Callable[[Array], Array]:
    """Return a function that copies measurements of all copies.

    It is ``finite`` if a copy has diverged; otherwise, all measurements are finite.
    """
    return finite if np.count_nonzero(diverged) else np.ndarray.copy


def columns(numbers: list[int]) -> slice | list[int]:
    """Return an index for columns: a slice, which is faster, if they are contiguous."""
    first = numbers[0] if numbers else 0
    row = slice(first, first + len(numbers))
    return row if numbers == list(range(row.start, row.stop)) else numbers
