"""The speed profiles of UR's manual, as formulas: what motions are compared with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def trapezoid(time: Array, distance: float, speed: float, acceleration: float) -> Array:
    """Return the way at times since the start, with the given limits."""
    top = min(speed, np.sqrt(acceleration * distance))
    ramp = top / acceleration
    duration = distance / top + ramp
    t = np.clip(time, 0.0, duration)
    rest = duration - t
    return np.where(
        t < ramp,
        0.5 * acceleration * t**2,
        np.where(
            rest < ramp,
            distance - 0.5 * acceleration * rest**2,
            top * (t - 0.5 * ramp),
        ),
    )


def start_of(time: Array, way: Array, acceleration: float) -> float:
    """Return when a motion from rest began, from its first sample that moved."""
    first = int(np.argmax(way > 1e-6))
    return float(time[first] - np.sqrt(2.0 * way[first] / acceleration))


def assert_trapezoid(
    time: Array, way: Array, *, distance: float, speed: float, acceleration: float
) -> None:
    """Compare a recorded way with its formula: within 1 mrad (or mm), and 1 ms.

    Where the motion is fast enough to tell, both have to be met.
    """
    t = time - start_of(time, way, acceleration)
    errors = np.abs(way - trapezoid(t, distance, speed, acceleration))
    assert errors.max() < 1e-3
    rates = np.gradient(trapezoid(t, distance, speed, acceleration), t)
    fast = rates > 0.1 * rates.max()
    assert fast.sum() > 20
    assert (errors[fast] / rates[fast]).max() < 1e-3
