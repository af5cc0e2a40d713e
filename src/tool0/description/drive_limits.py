"""Limits that apply to a gripper's drive while one goal is executed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from tool0.description.model import ParallelGripper
from tool0.errors import ControlError


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DriveLimits:
    """Speed and force limits of a gripper goal, equivalent to rSP and rFR.

    Speed and force are those of the pads.  The limits of the joint depend on its
    position: ``velocity = speed / lever`` and ``effort = force · lever``.

    Raises:
        ControlError: If a value is outside the gripper's range.
    """

    gripper: ParallelGripper
    speed: float | None = None
    """Largest speed of the pads relative to each other [m/s].  If ``speed`` is None,
    the joint's velocity limit applies."""
    force: float | None = None
    """Largest force at each pad [N].  If ``force`` is None, the joint's effort limit
    applies."""
    effort: float | None = None
    """Largest effort of the driven joint [N·m | N], as an alternative to ``force``."""

    def __post_init__(self) -> None:
        if self.force is not None and self.effort is not None:
            raise ControlError(
                f"give a force ({self.force} N at the pads) or an effort "
                f"({self.effort} of the joint), not both"
            )
        _check("speed", self.speed, self.gripper.speed, "m/s")
        _check("force", self.force, self.gripper.force, "N")
        if self.effort is not None and not 0.0 < self.effort < math.inf:
            raise ControlError(f"effort must be above 0 and finite, got {self.effort}")

    def at(self, position: float) -> tuple[float, float]:
        """Return the largest effort and velocity at a ``position`` of the joint.

        The effort is in [N·m | N], and the velocity is in [rad/s | m/s].
        """
        lever = self.gripper.lever(position)
        effort = math.inf if self.effort is None else self.effort
        if self.force is not None:
            effort = self.force * lever
        if self.speed is None or lever <= 0.0:
            return effort, math.inf
        return effort, self.speed / lever


def _check(
    what: str, value: float | None, span: tuple[float, float], unit: str
) -> None:
    if value is not None and not span[0] <= value <= span[1]:
        raise ControlError(
            f"{what} {value} {unit} is outside [{span[0]}, {span[1]}] {unit}"
        )
