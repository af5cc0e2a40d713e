"""Bounds and column indices of observations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tool0.batch.arguments import are_finite
from tool0.kinematics.chain import Array

FARTHEST = 10.0
"""Largest absolute value of a coordinate [m]."""
FASTEST_OBJECT = 20.0
"""Largest absolute value of a velocity component of an object [m/s]."""
STRONGEST, MOST_TORQUE = 1000.0, 100.0
"""Largest absolute values of a force component [N] and a torque component [N·m]."""


def finite(values: Array) -> Array:
    """Return a copy of an array in which finite numbers replace all other values."""
    if are_finite(values):
        return values.copy()
    return np.nan_to_num(values, nan=0.0, posinf=FARTHEST, neginf=-FARTHEST)


def reading(diverged: NDArray[np.bool_]) -> Callable[[Array], Array]:
    """Return a function that copies measurements of all copies.

    The function is ``finite`` if a copy has diverged; otherwise, it is a plain copy,
    because all measurements are finite.
    """
    return finite if np.count_nonzero(diverged) else np.ndarray.copy


def columns(numbers: list[int]) -> slice | list[int]:
    """Return an index for columns, which is a faster slice if they are contiguous."""
    first = numbers[0] if numbers else 0
    row = slice(first, first + len(numbers))
    return row if numbers == list(range(row.start, row.stop)) else numbers
