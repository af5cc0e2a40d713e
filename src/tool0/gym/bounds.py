"""Bounds of what is observed."""

from __future__ import annotations

import numpy as np

from tool0.kinematics.chain import Array

FARTHEST = 10.0
"""Of coordinates [m]."""
FASTEST_OBJECT = 20.0
"""Of velocities of objects [m/s]."""
STRONGEST, MOST_TORQUE = 1000.0, 100.0
"""Of wrenches [N], [N·m]."""


def finite(values: Array) -> Array:
    """Return a copy in which what diverged is a number, too."""
    if np.isfinite(values).all():
        return values.copy()
    return np.nan_to_num(values, nan=0.0, posinf=FARTHEST, neginf=-FARTHEST)
