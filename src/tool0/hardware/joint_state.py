"""What the joints do now: the one value that flows from engine to controllers."""

from __future__ import annotations

from typing import NamedTuple


class JointState(NamedTuple):
    """The measured state of every movable joint at one instant.

    Lists have shape (n_joints,), ordered as the engine's ``joint_names``.  A named
    tuple of plain lists: the tick makes one a thousand times a second, and plain
    floats are what Python computes with fastest.
    """

    time: float
    """Simulated time [s]."""
    position: list[float]
    """[rad], or [m] for a prismatic joint."""
    velocity: list[float]
    """[rad/s] or [m/s]."""
    effort: list[float]
    """Last applied effort [N·m] or [N]."""
