"""Rules of the plans of moves, beside the joints' positions and velocities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

from tool0.description.model import Joint

TIME_TO_FULL_ACCELERATION: Final = 0.1
"""Time to the full acceleration where the jerk is limited [s]; a guess: shorter makes
the arm ring, longer feels slow."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class MoveRules:
    """Limits and precision of planned moves."""

    accelerations: tuple[float, ...]
    """Largest accelerations of the joints [rad/s²], shape (6,)."""
    step: float
    """Distance between the poses that are solved [m]; less where the joints need it."""
    step_angle: float
    """The same for rotations of the tool [rad]."""
    tolerance: float
    """Largest distance of the flange from its path between two of them [m]."""
    unchecked_steps: int
    """The end of a path of more steps is solved first: it may be far out of reach."""
    smoothing: float
    """Time in which the acceleration along a move from rest to rest changes [s]."""
    excess: float
    """Fraction by which an acceleration may exceed its limit."""
    slowest: float
    """A move that must be slower than this part of its speed passes a singularity."""
    remedy: str
    """The end of the messages of errors."""


UR_RULES: Final = MoveRules(
    # The largest that ur_rtde accepts, https://gitlab.com/sdurobotics/ur_rtde.
    accelerations=(40.0,) * 6,
    step=0.004,
    step_angle=0.025,
    tolerance=2e-5,
    unchecked_steps=500,
    smoothing=0.0,
    excess=1e-9,
    slowest=0.02,
    remedy="choose another pose or via pose, start in another posture, or use movej",
)
"""Rules of programs and of Universal Robots' moves."""


def trajectory_rules(joints: Sequence[Joint]) -> MoveRules:
    """Return the rules of lines that a trajectory controller follows.

    The joints keep to their accelerations, and the line is as slow as they need.  The
    tool stays within 0.01 mm of it.
    """
    return MoveRules(
        accelerations=tuple(joint.max_acceleration for joint in joints),
        step=0.002,
        step_angle=0.01,
        tolerance=1e-6,
        unchecked_steps=0,
        smoothing=TIME_TO_FULL_ACCELERATION,
        excess=1e-3,
        slowest=1e-6,
        remedy="choose another line, start in another branch, or use move_to",
    )
