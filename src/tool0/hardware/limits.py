"""Joint limits as ros_control's saturation enforces them on an effort command.

joint_limits_interface (ros_control noetic, ``joint_limits_interface.h``), the
``EffortJointSaturationHandle`` and ``EffortJointSoftLimitsHandle``: the effort is
clamped, a joint beyond a position limit gets no effort outwards, one beyond its speed
no effort that drives it on.  Two things differ, on purpose:

* A drive whose rotor inertia is known keeps to its speed by that
  (``SpeedLimiter``).  ROS switches the whole effort on and off there, and a light
  joint then runs far above its limit on average.
* ``k_velocity = 0`` means "no soft limit on effort".  ROS takes it as a window of
  width zero, so that the UR description's own ``safety_limits:=true`` makes an
  effort-controlled arm limp.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import final

from tool0.description.model import JointLimits, SafetyController
from tool0.hardware.drive_limits import DriveLimits, SpeedLimiter
from tool0.hardware.joint_state import JointState

STOP_TOLERANCE = 1e-4
"""How far into its stop a joint may rest before effort outwards ends [rad | m].

A position limit is a contact, and contacts give way a little.  Without this margin the
effort would switch on and off a thousand times a second on a joint held at its stop.
"""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EffortLimits:
    """All that limits the effort of one joint, whatever the goal."""

    hard: JointLimits
    soft: SafetyController | None = None
    armature: float = 0.0
    """Inertia of the rotor as the joint feels it [kg·m²]; 0 if not known."""


@final
class EffortLimiter:
    """Saturates the effort of every driven joint, each step."""

    def __init__(self, drives: Mapping[int, EffortLimits], dt: float) -> None:
        """Take the limits of the driven joints, by index, and the step [s]."""
        self._drives = drives
        self._soft = [
            (i, drive.hard, drive.soft)
            for i, drive in drives.items()
            if drive.soft is not None and drive.soft.k_velocity > 0.0
        ]
        self._dt = dt
        self._drive_limits: dict[int, DriveLimits] = {}
        self.restart()

    @property
    def drive_limits(self) -> Mapping[int, DriveLimits]:
        """The limits of goals, by the joint's index."""
        return self._drive_limits

    def set_drive_limits(self, index: int, limits: DriveLimits | None) -> None:
        """Limit a drive below its joint's limits; None lifts that."""
        if limits == self._drive_limits.get(index):
            return
        if limits is None:
            del self._drive_limits[index]
        else:
            self._drive_limits[index] = limits
        drive = self._drives[index]
        if index not in self._speed_limiters:
            self._speed_limiters[index] = self._speed_limiter(drive)
        elif limits is None and drive.armature == 0.0:
            del self._speed_limiters[index]
        if index in self._speed_limiters:
            self._speed_limiters[index].drive_limits = limits
        self._rows = list(self._saturated())

    def restart(self) -> None:
        """Lift the limits of goals, and forget how the rotors answered."""
        self._drive_limits.clear()
        self._speed_limiters = {
            i: self._speed_limiter(drive)
            for i, drive in self._drives.items()
            if drive.armature > 0.0
        }
        self._rows = list(self._saturated())

    def saturate(
        self, effort: list[float], state: JointState, gravity: Sequence[float]
    ) -> None:
        """Bound ``effort`` [N·m | N] in place.

        ``gravity`` is the part of it that compensates gravity, where there are
        ``drive_limits``; both have shape (n_joints,).
        """
        _, position, velocity, applied = state
        for i, limiter in self._speed_limiters.items():
            effort[i] = limiter.limit(
                effort[i], applied[i], gravity[i], position[i], velocity[i]
            )
        for i, most, lower, upper, speed in self._rows:
            u = effort[i]
            if (
                -most <= u <= most
                and -speed <= velocity[i] <= speed
                and lower <= position[i] <= upper
            ):
                continue  # as nearly always: nothing binds
            if u > 0.0:
                is_over = position[i] > upper or velocity[i] > speed
                effort[i] = 0.0 if is_over else min(u, most)
            elif u < 0.0:
                is_over = position[i] < lower or velocity[i] < -speed
                effort[i] = 0.0 if is_over else max(u, -most)
        for i, hard, soft in self._soft:
            effort[i] = _soften(effort[i], position[i], velocity[i], hard, soft)

    def _speed_limiter(self, drive: EffortLimits) -> SpeedLimiter:
        return SpeedLimiter(drive.hard, armature=drive.armature, dt=self._dt)

    def _saturated(self) -> Iterator[tuple[int, float, float, float, float]]:
        """Yield all that ``saturate`` needs of each joint."""
        for i, drive in self._drives.items():
            hard = drive.hard
            # A drive with a speed limiter keeps to its speed by that.
            speed = math.inf if i in self._speed_limiters else hard.velocity
            lower, upper = hard.lower - STOP_TOLERANCE, hard.upper + STOP_TOLERANCE
            yield i, hard.effort, lower, upper, speed


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
