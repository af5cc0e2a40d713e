"""Rules for planning moves, in addition to limits of joint position and velocity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

from tool0.description.model import Joint

TIME_TO_FULL_ACCELERATION: Final = 0.1
"""Time to reach full acceleration where the jerk is limited [s]; a guess: with less the
arm rings, with more it feels slow."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class MoveRules:
    """Limits and precision of planned moves."""

    accelerations: tuple[float, ...]
    """Largest accelerations of the joints [rad/s²], shape (6,)."""
    step: float
    """Distance between poses for which inverse kinematics is solved [m]; less where the
    joints need it."""
    step_angle: float
    """Rotation of the tool between these poses [rad]."""
    tolerance: float
    """Largest distance of the flange from its path between two solved poses [m]."""
    unchecked_steps: int
    """Number of steps above which a path's end is solved first, as it may be out of
    reach."""
    smoothing: float
    """Time in which the acceleration along a move from rest to rest changes [s]."""
    excess: float
    """Fraction by which an acceleration may exceed its limit."""
    slowest: float
    """Fraction of its speed below which a slowed move counts as passing a
    singularity."""
    remedy: str
    """Text at the end of error messages."""


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
"""Rules for programs and Universal Robots' moves."""


def trajectory_rules(joints: Sequence[Joint]) -> MoveRules:
    """Return the rules for lines that a trajectory controller follows.

    The joints keep within their acceleration limits, and the line is as slow as this
    requires.  The tool stays within 0.01 mm of the line.
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
