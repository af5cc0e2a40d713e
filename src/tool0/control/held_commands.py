"""The newest command of a controller that takes a number for each joint."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import final

from tool0.control.spline import JointSpline, hold
from tool0.control.trajectory import Setpoint
from tool0.description.model import Joint
from tool0.errors import ControlError
from tool0.hardware.engine import JointSelector, JointState


def checked_commands(
    values: Sequence[float] | float,
    size: int,
    *,
    wrong_size: Callable[[int], str],
    not_finite: Callable[[int, float], str],
) -> list[float]:
    """Return one command per joint.

    Args:
        values: What was given; a number for a single joint.
        size: The number of joints.
        wrong_size: Returns the message for another count.
        not_finite: Returns the message for a value of a joint, by its number.

    Raises:
        ControlError: If the count is wrong or a number is not finite.
    """
    given = [values] if isinstance(values, int | float) else list(values)
    if len(given) != size:
        raise ControlError(wrong_size(len(given)))
    for k, value in enumerate(given):
        if not math.isfinite(value):
            raise ControlError(not_finite(k, value))
    return [float(value) for value in given]


@final
class HeldPositions:
    """The setpoint of joints whose positions are commanded, made on request."""

    def __init__(self, joints: tuple[Joint, ...], select: JointSelector) -> None:
        self._joints = joints
        self._select = select
        self._positions: Sequence[float] | None = None
        self._holds: tuple[JointSpline, ...] = ()

    def command(self, positions: Sequence[float]) -> None:
        """Take the newest command [rad | m]."""
        self._positions, self._holds = positions, ()

    def setpoint(self, state: JointState) -> Setpoint | None:
        """Return the setpoint at ``state``; None before the first command."""
        if self._positions is None:
            return None
        if not self._holds:
            self._holds = tuple(hold(state.time, value) for value in self._positions)
        return Setpoint(self._joints, self._holds, self._select, state)
