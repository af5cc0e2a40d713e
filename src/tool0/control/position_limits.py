"""The positions that a controller accepts for a joint."""

from __future__ import annotations

import math
from collections.abc import Mapping

from tool0.control.controller import TrajectorySpec
from tool0.description.model import Joint, JointType
from tool0.description.units import ANGLE, LENGTH
from tool0.errors import GoalRejectedError, did_you_mean

ROUNDING = 1e-6
"""Accepted excess over a limit [rad | m], since printed limits are rounded."""


def check_position(
    joint: Joint, position: float, where: str, start: float | None = None
) -> None:
    """Reject a position beyond the joint's limits.

    A continuous joint has no limits.

    ``start`` is the position at which the motion starts.  If ``start`` is None, the
    position is assumed to be within the limits.
    """
    if joint.type is JointType.CONTINUOUS:
        return
    lowest, highest = position_range(joint, start)
    if not lowest <= position <= highest:
        lower, upper = joint.limits.lower, joint.limits.upper
        quantity = LENGTH if joint.type is JointType.PRISMATIC else ANGLE
        raise GoalRejectedError(
            f"{where} moves joint '{joint.name}' to {position:.6g}, "
            f"which is beyond its limits [{lower:.6g}, {upper:.6g}]"
            + quantity.suggestion(position, lambda meant: lower <= meant <= upper)
        )


def position_range(joint: Joint, start: float | None = None) -> tuple[float, float]:
    """Return the smallest and the largest accepted position [rad | m].

    ``start`` is the position at which the motion starts.  If ``start`` is None, the
    position is assumed to be within the limits.
    """
    if joint.type is JointType.CONTINUOUS:
        return -math.inf, math.inf
    limits = joint.limits
    lower, upper = limits.lower, limits.upper
    if start is not None:
        lower, upper = limits.range_from(start)
    return lower - ROUNDING, upper + ROUNDING


def check_targets(
    spec: TrajectorySpec, positions: Mapping[str, float], what: str
) -> None:
    """Raise GoalRejectedError if a controller cannot move joints to ``positions``.

    ``what`` is the name of the checked motion in the error message.
    """
    for name, position in positions.items():
        if name not in spec.joints:
            raise GoalRejectedError(
                f"joint '{name}' is not one of '{spec.name}'"
                + did_you_mean(name, spec.joints),
                GoalRejectedError.INVALID_JOINTS,
            )
        if not math.isfinite(position):
            raise GoalRejectedError(
                f"position {position} for joint '{name}'; it must be finite"
            )
    for joint in spec.joint_models:
        if joint.name in positions:
            check_position(joint, positions[joint.name], what)
