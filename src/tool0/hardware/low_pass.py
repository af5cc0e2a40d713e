"""A low-pass filter for what a sensor samples at a steady rate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

from tool0.errors import ControlError


@final
class LowPass:
    """Butterworth's of second order, for several values at once.

    H(s) = 1 / (s² + √2 s + 1), s in units of the cutoff, made discrete by the bilinear
    transform with the cutoff where it is wanted:

        y = b0 x + 2 b0 x' + b0 x" - a1 y' - a2 y",  K = tan(π cutoff / rate),
        b0 = K² / d,  a1 = 2 (K² - 1) / d,  a2 = (1 - √2 K + K²) / d,  d = 1 + √2 K + K²

    The cutoff passes at 0.71 of its amplitude, ten times that at 0.01.  A ramp is
    0.225 / cutoff late: 15 ms at 15 Hz.  The first sample is taken to have been there
    always.
    """

    def __init__(self, cutoff: float, rate: float) -> None:
        """Begin anew.

        Args:
            cutoff: [Hz], below half the rate.
            rate: Samples per second [Hz].

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
        self._b0 = k * k / d
        self._a1 = 2.0 * (k * k - 1.0) / d
        self._a2 = (1.0 - math.sqrt(2.0) * k + k * k) / d
        self._memory: list[tuple[float, float]] = []

    def __call__(self, values: Sequence[float]) -> list[float]:
        """Return what passes of the next sample."""
        b0, a1, a2 = self._b0, self._a1, self._a2
        if not self._memory:
            self._memory = [((1.0 - b0) * x, (b0 - a2) * x) for x in values]
        passed, memory = [], []
        for x, (first, second) in zip(values, self._memory, strict=True):
            y = b0 * x + first
            passed.append(y)
            memory.append((2.0 * b0 * x - a1 * y + second, b0 * x - a2 * y))
        self._memory = memory
        return passed
