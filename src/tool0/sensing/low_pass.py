"""The low-pass filter of force-torque sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, final

from tool0.errors import ControlError


class SecondOrder(NamedTuple):
    """A second-order Butterworth low-pass filter.

    The transfer function is H(s) = 1 / (s² + √2 s + 1), with s in units of the cutoff.
    The filter is discretized by the bilinear transform with frequency prewarping at the
    cutoff:

        y = b0 x + 2 b0 x' + b0 x" - a1 y' - a2 y",  K = tan(π cutoff / rate),
        b0 = K² / d,  a1 = 2 (K² - 1) / d,  a2 = (1 - √2 K + K²) / d,  d = 1 + √2 K + K²

    The gain is 0.71 at the cutoff and 0.01 at ten times the cutoff. A ramp is delayed
    by 0.225 / cutoff, which is 15 ms at 15 Hz.
    """

    b0: float
    a1: float
    a2: float

    @staticmethod
    def of(cutoff: float, rate: float) -> SecondOrder:
        """Return the filter for a cutoff frequency and a sampling rate.

        Args:
            cutoff: Cutoff frequency [Hz], which must be below half the rate.
            rate: Sampling rate [Hz].

        Raises:
            ControlError: If the cutoff is out of range.
        """
        if not 0.0 < cutoff < rate / 2.0:
            raise ControlError(
                f"the cutoff must be above 0 Hz and below half the rate, "
                f"{rate / 2.0:g} Hz; got {cutoff:g} Hz"
            )
        k = math.tan(math.pi * cutoff / rate)
        d = 1.0 + math.sqrt(2.0) * k + k * k
        return SecondOrder(
            k * k / d,
            2.0 * (k * k - 1.0) / d,
            (1.0 - math.sqrt(2.0) * k + k * k) / d,
        )


@final
class LowPass:
    """A ``SecondOrder`` filter for several values at the same time.

    The initial state corresponds to a constant input that is equal to the first sample.
    """

    def __init__(self, cutoff: float, rate: float) -> None:
        """Initialize the filter; see ``SecondOrder.of`` for arguments and errors."""
        self._filter = SecondOrder.of(cutoff, rate)
        self._memory: list[tuple[float, float]] = []

    def __call__(self, values: Sequence[float]) -> list[float]:
        """Return the filtered values of the next sample."""
        b0, a1, a2 = self._filter
        if not self._memory:
            self._memory = [((1.0 - b0) * x, (b0 - a2) * x) for x in values]
        passed, memory = [], []
        for x, (first, second) in zip(values, self._memory, strict=True):
            y = b0 * x + first
            passed.append(y)
            memory.append((2.0 * b0 * x - a1 * y + second, b0 * x - a2 * y))
        self._memory = memory
        return passed
