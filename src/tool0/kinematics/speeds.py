"""How fast joints may move."""

from __future__ import annotations

import math

from tool0.description.model import Joint, JointType

UNLIMITED = {JointType.PRISMATIC: 0.25}
"""Velocity of joints whose model gives none [m/s]."""
UNLIMITED_TURN = 1.0
"""The same of joints that turn [rad/s]."""


def largest_velocity(joint: Joint) -> float:
    """Return how fast a joint may move [rad/s | m/s], by its model or by a guess."""
    if math.isfinite(joint.limits.velocity):
        return joint.limits.velocity
    return UNLIMITED.get(joint.type, UNLIMITED_TURN)
