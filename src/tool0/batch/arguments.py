"""Checks of the arrays with one row per copy that callers pass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeVar, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tool0.control.ros1.goal_check import INSTANT
from tool0.errors import ControlError
from tool0.kinematics.chain import Array

Which = Sequence[int] | Sequence[bool] | NDArray[np.integer] | NDArray[np.bool_] | int
"""Selection of copies: a mask of shape (n,), or the numbers of the copies."""
Indices = NDArray[np.intp]
Scalar = TypeVar("Scalar", bound=np.generic)


def are_finite(values: Array) -> bool:
    """Return whether all values are finite; first test the sum of squares (fast)."""
    return math.isfinite(np.vdot(values, values)) or bool(np.isfinite(values).all())


def chosen(values: NDArray[Scalar], rows: Indices) -> NDArray[Scalar]:
    """Return rows of ``values``, shape (n, …), without a copy if all rows are chosen.

    ``rows`` are distinct, increasing numbers of copies.
    """
    return values if len(rows) == len(values) else values[rows]


@final
class Arguments:
    """Checks the arguments of one method."""

    def __init__(self, n: int, method: str) -> None:
        """Check arguments of ``method`` for ``n`` copies."""
        self._n = n
        self._method = method

    def which(self, given: Which | None) -> Indices:
        """Return the numbers of the chosen copies; None chooses all copies.

        Raises:
            ControlError: If ``given`` is neither a mask of shape (n,) nor numbers of
                copies.
        """
        n = self._n
        if given is None:
            return np.arange(n)
        values = np.atleast_1d(np.asarray(given))
        if values.dtype == np.bool_:
            if values.shape != (n,):
                raise self._error(
                    f"the mask 'which' has shape {values.shape}; it must be ({n},), "
                    "one per copy"
                )
            return values.nonzero()[0]
        if values.size == 0:
            return np.empty(0, np.intp)
        if values.ndim != 1 or not np.issubdtype(values.dtype, np.integer):
            raise self._error(
                f"'which' must be a mask of shape ({n},) or a list of copies, got "
                f"{values.dtype} of shape {values.shape}"
            )
        for number in values.tolist():
            if not 0 <= number < n:
                raise self._error(f"'which' names copy {number}; there are 0 … {n - 1}")
        return np.unique(values).astype(np.intp)

    def rows(
        self,
        name: str,
        values: ArrayLike,
        shape: tuple[int, ...],
        which: Indices,
        axes: str = "",
    ) -> Array:
        """Return ``values`` for each copy, one row per copy.

        A value of shape ``shape``, without the axis of the copies, applies to all
        copies.  ``axes`` explains the shape in error messages.

        Raises:
            ControlError: If the shape is wrong, or a number for a chosen copy is not
                finite.
        """
        whole = (self._n, *shape)
        try:
            given: Array = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError):
            raise self._error(
                f"'{name}' must be numbers of shape {whole}{axes}, got {values!r:.80}"
            ) from None
        if given.shape == shape:
            value, given = given, np.empty(whole)
            given[...] = value
        if given.shape != whole:
            raise self._error(
                f"'{name}' has shape {given.shape}; it must be {whole}{axes}, or "
                f"{shape} for all copies alike"
            )
        if not are_finite(given) and not are_finite(given[which]):
            at = np.argwhere(~np.isfinite(given[which]))[0]
            index = (int(which[at[0]]), *map(int, at[1:]))
            raise self._error(
                f"'{name}' has {given[index]} at {list(index)}; every number must be "
                "finite"
            )
        return given

    def on_device(
        self,
        name: str,
        values: object,
        shape: tuple[int, ...],
        axes: str,
        *,
        is_held: bool,
    ) -> None:
        """Raise ControlError unless ``values`` is an array with n rows on the device.

        ``is_held`` is true if the array is in the device's memory.
        """
        whole, found = (self._n, *shape), tuple(getattr(values, "shape", ()))
        if not is_held:
            raise self._error(f"'{name}' must be on the device, as the other array")
        if found != whole:
            raise self._error(f"'{name}' has shape {found}; it must be {whole}{axes}")

    def duration(self, value: float) -> float:
        """Return a duration [s]; raise ControlError unless it is above ``INSTANT``."""
        name = "duration"
        if not isinstance(value, int | float | np.floating | np.integer):
            raise self._error(f"'{name}' must be a number, got {value!r:.80}")
        if not INSTANT < float(value) < math.inf:
            raise self._error(
                f"'{name}' must be above {INSTANT:g} s and finite, got {value}"
            )
        return float(value)

    def times(self, values: ArrayLike) -> list[float]:
        """Return times [s].

        Raises:
            ControlError: Unless the times increase and are above ``INSTANT``.
        """
        given = np.asarray(values, dtype=np.float64)
        steps = np.diff(given, prepend=INSTANT) if given.ndim == 1 else np.zeros(0)
        if not given.size or not (steps > 0.0).all():
            raise self._error(
                f"'times' must be numbers above {INSTANT:g} s, each above the one "
                f"before, got {values!r:.80}"
            )
        return [float(value) for value in given]

    def _error(self, problem: str) -> ControlError:
        return ControlError(f"Batch.{self._method}: {problem}")
