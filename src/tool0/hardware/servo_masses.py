"""The masses that scale servos, bounded for stability with wrong payloads.

A servo of natural frequency ω and damping ratio ζ is scaled by a mass matrix Mₛ, where
the mass matrix of the joints is M.  With Mₛ = r M, the servo's gains are r times too
large.  In continuous time, proportional and derivative gains are stable for every
r > 0.  Two bounds remain:

* With steps of dt, the derivative gain is stable only for 2 ζ ω r dt < 2.  Whatever
  payload is declared, the joints have at least the masses of the description.  Mₛ may
  therefore exceed the description's masses only by a limited factor.  A light joint
  with a strong drive (wrist_3 of a bare arm has 1e-4 kg·m²) uses this margin, which
  makes it stiff under an undeclared load.
* An integral of rate k requires r > k / (2 ζ ω) (Routh's criterion).  The joints may
  carry more than the declared payload, so that k is limited by the largest load of the
  drive.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from tool0.description.bodies import STANDARD_GRAVITY, Matrix
from tool0.hardware.servos import BANDWIDTH, DAMPING_RATIO, INTEGRAL_RATE

_RATE: Final = 2.0 * DAMPING_RATIO * BANDWIDTH
"""Decay rate of velocities [1/s]."""
_STEP_GAIN: Final = 0.8
"""Largest value of 2 ζ ω r dt.  A servo becomes unstable at 2."""
_INTEGRAL_SHARE: Final = 0.25
"""Largest integral rate, as a fraction of the rate at which it becomes unstable."""
_LEVER: Final = 0.2
"""Distance of the largest load from the joint [m].  At this distance, the drive can
just carry the largest load.  The value is of the order of the offsets in UR's payload
diagrams."""
_EXPECTED_SHARE: Final = 0.02
"""Inertia that a servo expects without a payload, as a fraction of the inertia of the
largest load.  The expected inertia makes the wrists of a UR stiffer, and makes little
difference to the other joints."""


def largest_ratio(dt: float) -> float:
    """Return the largest ratio r of the masses for steps of ``dt`` [s]."""
    return max(1.0, _STEP_GAIN / (_RATE * dt))


def bounded_masses(own: Matrix, declared: Matrix, ratio: float) -> Matrix:
    """Return the mass matrix ``declared``, limited to 1 … ``ratio`` times ``own``.

    Both matrices have shape (…, n, n).  ``own`` is the mass matrix of the description,
    which is positive definite.  The ratio is limited along each of the generalized
    eigenvectors, so that the light direction of a wrist does not limit the shoulder.
    """
    lower = np.linalg.cholesky(own)
    inverse = np.linalg.inv(lower)
    ratios, axes = np.linalg.eigh(inverse @ declared @ np.swapaxes(inverse, -1, -2))
    is_within = (ratios[..., 0] >= 1.0) & (ratios[..., -1] <= ratio)
    if is_within.all():
        return declared
    root = lower @ axes
    bounded = root * np.clip(ratios, 1.0, ratio)[..., None, :]
    bounded = bounded @ np.swapaxes(root, -1, -2)
    return np.where(is_within[..., None, None], declared, bounded)


def expected_load(effort: float) -> float:
    """Return the load inertia that a joint's servo always assumes [kg·m²].

    ``effort`` is the largest effort of the joint's drive [N·m].
    """
    return 0.0 if math.isinf(effort) else _EXPECTED_SHARE * _largest_load(effort)


def integral_rate(inertia: float, effort: float, dt: float) -> float:
    """Return the integral rate of a joint that carries a payload [1/s].

    Args:
        inertia: Inertia at the joint in the description [kg·m²].
        effort: Largest effort of the joint's drive [N·m].
        dt: Length of a step [s].
    """
    if math.isinf(effort):
        return INTEGRAL_RATE
    scaled = min(inertia + expected_load(effort), largest_ratio(dt) * inertia)
    smallest = scaled / (inertia + _largest_load(effort))
    return min(INTEGRAL_RATE, _INTEGRAL_SHARE * _RATE * smallest)


def _largest_load(effort: float) -> float:
    return effort * _LEVER / -STANDARD_GRAVITY[2]
