"""Joint limits as ros_control's saturation enforces them on an effort command.

joint_limits_interface (ros_control noetic, ``joint_limits_interface.h``), the
``EffortJointSaturationHandle`` and ``EffortJointSoftLimitsHandle``: the effort is
clamped, a joint beyond a position limit gets no effort outwards, one beyond its speed
no effort that drives it on.  Two things differ, on purpose:

* A drive whose rotor inertia is known gets no more effort than takes its rotor to the
  speed limit within the step.  ROS switches the whole effort on and off there, and a
  light joint then runs far above its limit on average.
* ``k_velocity = 0`` means "no soft limit on effort".  ROS takes it as a window of
  width zero, so that the UR description's own ``safety_limits:=true`` makes an
  effort-controlled arm limp.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from tool0.description.model import JointLimits, SafetyController

STOP_TOLERANCE = 1e-4
"""How far into its stop a joint may rest before effort outwards ends [rad | m].

A position limit is a contact, and contacts give way a little.  Without this margin the
effort would switch on and off a thousand times a second on a joint held at its stop.
"""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DriveLimits:
    """All that bounds the effort of one joint."""

    hard: JointLimits
    soft: SafetyController | None = None
    armature: float = 0.0
    """Inertia of the rotor as the joint feels it [kg·m²]; 0 if not known."""


@final
class EffortLimiter:
    """Saturates the effort of every driven joint, each step."""

    def __init__(
        self, indices: Sequence[int], drives: Sequence[DriveLimits], dt: float
    ) -> None:
        self._soft = [
            (i, drive.hard, drive.soft)
            for i, drive in zip(indices, drives, strict=True)
            if drive.soft is not None and drive.soft.k_velocity > 0.0
        ]
        self._indices = {index: row for row, index in enumerate(indices)}
        self._rows = [
            _row(i, drive, drive.hard.effort, dt)
            for i, drive in zip(indices, drives, strict=True)
        ]
        self._drives = tuple(drives)
        self._dt = dt

    def cap(self, index: int, effort: float | None) -> None:
        """Bound the effort of a joint below its limit; None takes the bound away."""
        row = self._indices[index]
        drive = self._drives[row]
        limit = drive.hard.effort
        most = limit if effort is None else min(limit, effort)
        self._rows[row] = _row(index, drive, most, self._dt)

    def saturate(
        self, effort: list[float], position: list[float], velocity: list[float]
    ) -> None:
        """Bound ``effort`` [N·m | N] in place."""
        for i, most, lower, upper, calm, speed, rotor in self._rows:
            u = effort[i]
            v = velocity[i]
            if (
                -most <= u <= most
                and -calm <= v <= calm
                and lower <= position[i] <= upper
            ):
                continue  # as nearly always: nothing binds
            if u > 0.0:
                u = min(u, most, max(0.0, (speed - v) * rotor))
                if position[i] > upper or v > speed:
                    u = 0.0
            elif u < 0.0:
                u = max(u, -most, min(0.0, -(speed + v) * rotor))
                if position[i] < lower or v < -speed:
                    u = 0.0
            effort[i] = u
        for i, hard, soft in self._soft:
            effort[i] = _soften(effort[i], position[i], velocity[i], hard, soft)


def _row(
    index: int, drive: DriveLimits, most: float, dt: float
) -> tuple[int, float, float, float, float, float, float]:
    """Return all that ``saturate`` needs of a joint.

    The last three: the speed below which no effort can reach the speed limit within a
    step, the speed limit, and the effort per speed that the rotor takes in a step.
    """
    hard = drive.hard
    rotor = drive.armature / dt if drive.armature > 0.0 else math.inf
    return (
        index,
        most,
        hard.lower - STOP_TOLERANCE,
        hard.upper + STOP_TOLERANCE,
        max(0.0, hard.velocity - most / rotor),
        hard.velocity,
        rotor,
    )


def velocity_window(
    position: float, hard: JointLimits, soft: SafetyController | None
) -> tuple[float, float]:
    """Return the velocities allowed at ``position`` (soft limits slow down early)."""
    most = hard.velocity
    if soft is None:
        return -most, most
    lower = -soft.k_position * (position - soft.soft_lower_limit)
    upper = -soft.k_position * (position - soft.soft_upper_limit)
    return min(max(lower, -most), most), min(max(upper, -most), most)


def _soften(
    effort: float,
    position: float,
    velocity: float,
    hard: JointLimits,
    soft: SafetyController,
) -> float:
    slowest, fastest = velocity_window(position, hard, soft)
    most = hard.effort
    lower = min(max(-soft.k_velocity * (velocity - slowest), -most), most)
    upper = min(max(-soft.k_velocity * (velocity - fastest), -most), most)
    return min(max(effort, lower), upper)
