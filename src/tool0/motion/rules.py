"""Rules for planning moves, in addition to the position and velocity limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

from tool0.description.model import Joint

TIME_TO_FULL_ACCELERATION: Final = 0.1
"""Time to reach full acceleration if the jerk is limited [s]. The value is a guess:
with a shorter time the arm vibrates, and with a longer time the motion feels slow."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class MoveRules:
    """Limits and precision for the planning of moves."""

    accelerations: tuple[float, ...]
    """Maximum accelerations of the joints [rad/s²], shape (6,)."""
    step: float
    """Distance between poses for which inverse kinematics is solved [m]. The distance
    is smaller where the joints require more poses."""
    step_angle: float
    """Rotation of the tool between poses for which inverse kinematics is solved
    [rad]."""
    tolerance: float
    """Maximum distance of the flange from its path between two solved poses [m]."""
    unchecked_steps: int
    """Number of steps above which the end of a path is solved first, because it may be
    out of reach."""
    smoothing: float
    """Duration of acceleration changes along a move from rest to rest [s]."""
    excess: float
    """Fraction by which an acceleration may exceed the acceleration limit."""
    slowest: float
    """Fraction of the requested speed below which a slowed move is considered to pass a
    singularity."""
    remedy: str
    """Advice at the end of error messages."""


UR_RULES: Final = MoveRules(
    # The maximum that ur_rtde accepts, https://gitlab.com/sdurobotics/ur_rtde.
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
"""Rules for programs and for moves of Universal Robots' arms."""


def trajectory_rules(joints: Sequence[Joint]) -> MoveRules:
    """Return the rules for lines that a trajectory controller follows.

    The joints stay within their acceleration limits, and the tool moves as slowly as
    these limits require. The tool deviates from the line by at most 0.01 mm.
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
