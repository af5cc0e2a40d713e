"""Joint limits, which are enforced as in ros_control.

Saturation follows ``EffortJointSaturationHandle`` and ``EffortJointSoftLimitsHandle``
of joint_limits_interface (ros_control noetic, ``joint_limits_interface.h``): the effort
is clamped, a joint beyond a position limit gets no outward effort, and a joint above
its speed limit gets no accelerating effort.  tool0's limits differ intentionally from
ROS in three ways:

* A drive whose rotor inertia is known, or whose effort could take the joint beyond its
  speed limit within one step, uses a ``SpeedLimiter``, which keeps the joint within its
  speed limit.  In ROS, the whole effort of a drive is switched on and off at the speed
  limit, so that a light joint runs far above its limit.
* The speed of a joint without a ``SpeedLimiter`` is governed
  (``hardware/speed_governor.py``).  With ROS's rule, the joints of an arm would
  accelerate each other to five times their speed limits.
* ``k_velocity = 0`` means "no soft limit on effort".  ROS instead uses a window of
  width zero, so that an effort-controlled arm is limp with ``safety_limits:=true`` in
  the UR description.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, final

from tool0.description.drive_limits import DriveLimits
from tool0.description.model import JointLimits, SafetyController
from tool0.hardware.engine import JointState

STOP_TOLERANCE = 1e-4
"""Depth of penetration into a stop beyond which outward effort is cut [rad | m].

A stop is simulated as a contact, and contacts yield a little.  Without a margin, the
effort of a joint held at its stop would switch on and off a thousand times a second.
"""


PUSHING = 0.9
"""Fraction of its effort limit above which a drive is considered to push at its limit.
The fraction is less than 1, because a servo scales down the accelerations of coupled
joints together, so that an effort may stay slightly below its limit."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EffortLimits:
    """The limits of one joint, independent of any goal."""

    hard: JointLimits
    soft: SafetyController | None = None
    inertia: float = 0.0
    """Rotor inertia reflected to the joint, or the inertia of a light joint
    [kg·m² | kg]; 0 for any other joint."""
    is_light: bool = False
    """Whether the drive could exceed the speed limit within one step.  If a drive could
    exceed the limit, its joint gets no outward effort within one step's travel of its
    stop.  The reason is that a stop acts only after the joint has passed it."""


class DriveBounds(NamedTuple):
    """Constants that the limiter uses for one drive."""

    joint: int
    """Index of the joint."""
    effort: float
    """Largest effort [N·m | N]."""
    velocity: float
    """Largest speed [rad/s | m/s]."""
    lower: float
    """Position below which the joint presses into its stop [rad | m]."""
    upper: float
    """Position above which the joint presses into its stop [rad | m]."""
    rotor: float
    """Inertia divided by the step length [N·m·s/rad | N·s/m], used to enforce the speed
    limit; infinite if the inertia is unknown."""
    ease: float
    """Largest reduction of the effort per step when the limits of a goal decrease
    [N·m | N]."""
    hard: JointLimits
    soft: SafetyController | None
    """Soft limits, or None if they do not limit the effort."""


@final
class EffortLimiter:
    """Saturates the effort of every driven joint in each step."""

    def __init__(self, drives: Mapping[int, EffortLimits], dt: float) -> None:
        """Set the limits of the driven joints, by index, and the step length [s]."""
        self._drives = drives
        self._dt = dt
        self.bounds = tuple(self._bounds())
        self._soft = [(b.joint, b.hard, b.soft) for b in self.bounds if b.soft]
        self._drive_limits: dict[int, DriveLimits] = {}
        self._governed: frozenset[int] = frozenset()
        self._added: Mapping[int, float] = {}
        self.restart()

    @property
    def drive_limits(self) -> Mapping[int, DriveLimits]:
        """The limits set by goals, by joint index."""
        return self._drive_limits

    @property
    def velocities(self) -> dict[int, float | None]:
        """State of the speed limiters, by joint index."""
        return {i: limiter.before for i, limiter in self._speed_limiters.items()}

    def restore(
        self,
        drive_limits: Mapping[int, DriveLimits],
        velocities: Mapping[int, float | None],
    ) -> None:
        """Restore the limits set by goals and the ``velocities`` of the last step."""
        if drive_limits != self._drive_limits:
            for i in self._drive_limits.keys() | drive_limits.keys():
                self.set_drive_limits(i, drive_limits.get(i))
        for i, limiter in self._speed_limiters.items():
            limiter.before = velocities[i]

    def set_drive_limits(self, index: int, limits: DriveLimits | None) -> None:
        """Limit a drive more tightly than its joint.

        None removes the drive's limits.
        """
        if limits == self._drive_limits.get(index):
            return
        if limits is None:
            del self._drive_limits[index]
        else:
            self._drive_limits[index] = limits
        drive = self._drives[index]
        if index not in self._speed_limiters:
            self._speed_limiters[index] = self._speed_limiter(drive)
        elif limits is None and drive.inertia == 0.0:
            del self._speed_limiters[index]
        if index in self._speed_limiters:
            self._speed_limiters[index].drive_limits = limits
        self._rows = list(self._saturated())

    def leave_speeds(self, governed: frozenset[int]) -> None:
        """Leave the limiting of joint speeds to the governor."""
        self._governed = governed
        self._rows = list(self._saturated())

    def add_inertias(self, inertias: Mapping[int, float]) -> None:
        """Add ``inertias``, by joint index, to the known inertias of the joints."""
        self._added = inertias
        for i in self._speed_limiters:
            limiter = self._speed_limiter(self._drives[i], inertias.get(i, 0.0))
            limiter.drive_limits = self._drive_limits.get(i)
            self._speed_limiters[i] = limiter

    def restart(self) -> None:
        """Remove the limits set by goals; clear the limiters' last velocities."""
        self._drive_limits.clear()
        self._speed_limiters = {
            i: self._speed_limiter(drive, self._added.get(i, 0.0))
            for i, drive in self._drives.items()
            if drive.inertia > 0.0
        }
        self._rows = list(self._saturated())

    def saturate(
        self, effort: list[float], state: JointState, gravity: Sequence[float]
    ) -> None:
        """Limit ``effort`` [N·m | N] in place.

        For joints with ``drive_limits``, ``gravity`` is the part of ``effort`` that
        compensates gravity.  ``effort`` and ``gravity`` have shape (n_joints,).
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
                continue  # usual case: no limit applies
            if u > 0.0:
                is_over = position[i] > upper or velocity[i] > speed
                effort[i] = 0.0 if is_over else min(u, most)
            elif u < 0.0:
                is_over = position[i] < lower or velocity[i] < -speed
                effort[i] = 0.0 if is_over else max(u, -most)
        for i, hard, soft in self._soft:
            effort[i] = _soften(effort[i], position[i], velocity[i], hard, soft)

    def _speed_limiter(self, drive: EffortLimits, added: float = 0.0) -> SpeedLimiter:
        inertia = drive.inertia + added if drive.inertia > 0.0 else 0.0
        return SpeedLimiter(drive.hard, inertia=inertia, dt=self._dt)

    def _saturated(self) -> Iterator[tuple[int, float, float, float, float]]:
        """Yield the constants that ``saturate`` needs, for one joint after another."""
        for i, effort, velocity, lower, upper, *_ in self.bounds:
            # The drive's speed limiter or the governor limits the speed of this joint.
            is_kept = i in self._speed_limiters or i in self._governed
            speed = math.inf if is_kept else velocity
            yield i, effort, lower, upper, speed

    def _bounds(self) -> Iterator[DriveBounds]:
        for i, drive in self._drives.items():
            hard, soft, limiter = drive.hard, drive.soft, self._speed_limiter(drive)
            margin = -hard.velocity * self._dt if drive.is_light else STOP_TOLERANCE
            yield DriveBounds(
                i,
                hard.effort,
                hard.velocity,
                hard.lower - margin,
                hard.upper + margin,
                limiter.rotor,
                limiter.ease,
                hard,
                soft if soft is not None and soft.k_velocity > 0.0 else None,
            )


def velocity_window(
    position: float, hard: JointLimits, soft: SafetyController | None
) -> tuple[float, float]:
    """Return the range of velocities that soft limits allow at ``position``."""
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


EASE = 0.05
"""Shortest time in which a drive removes all its effort when its limits decrease [s].
This time is several oscillation periods of the rotor and pads on a squeezed object
(13 ms for a 2F-85), so that a weakening grip does not drop the object.  The value is an
estimate, because no datasheet gives it."""


@final
class SpeedLimiter:
    """Limits the effort of one drive so that the joint does not exceed its speed limit.

    A rotor of known inertia gets at most the effort that brings it to the largest speed
    within the step, plus the resistance in the last step.  The rotor therefore
    maintains the largest speed despite friction, does not exceed it when suddenly
    unloaded, and presses against an obstacle with its full effort.
    """

    def __init__(self, hard: JointLimits, *, inertia: float, dt: float) -> None:
        """Start with no resistance at the rotor.

        ``inertia`` is the rotor's inertia reflected to the joint [kg·m²], or 0 if it is
        unknown.  ``dt`` is the length of a step [s].
        """
        self._effort = hard.effort
        self._speed = hard.velocity
        self.rotor = inertia / dt if inertia > 0.0 else math.inf
        """Inertia divided by the step length [N·m·s/rad | N·s/m]."""
        self.ease = hard.effort * dt / EASE
        """Largest reduction of the effort per step when limits decrease [N·m | N]."""
        self.before: float | None = None
        """Velocity in the last step [rad/s | m/s]; None if no limit was close."""
        self.drive_limits: DriveLimits | None = None
        """Limits of the goal; if None, only the joint's limits apply."""

    def limit(
        self,
        effort: float,
        applied: float,
        gravity: float,
        position: float,
        velocity: float,
    ) -> float:
        """Return ``effort`` [N·m | N] within the limits.

        Args:
            effort: The requested effort.
            applied: The effort applied in the last step.
            gravity: The part of ``effort`` that compensates gravity; the limits of a
                goal do not apply to this part.
            position: Position of the joint [rad | m].
            velocity: Velocity of the joint [rad/s | m/s].
        """
        most, speed = self._effort, self._speed
        if (
            self.drive_limits is None
            and -most <= effort <= most
            and abs(velocity) + abs(effort) / self.rotor <= speed
        ):
            self.before = None
            return effort  # usual case: no limit applies
        if self.drive_limits is not None:
            grip, fastest = self.drive_limits.at(position)
            # An effort that exceeds new limits is reduced step by step.
            lowest = min(gravity - grip, applied + self.ease)
            highest = max(gravity + grip, applied - self.ease)
            effort = min(max(effort, lowest), highest)
            speed = min(speed, fastest)
        effort = min(max(effort, -most), most)
        before, self.before = self.before, velocity
        if self.rotor == math.inf:
            is_too_fast = velocity > speed if effort > 0.0 else velocity < -speed
            return 0.0 if is_too_fast else effort
        held_back = 0.0
        if before is not None:
            held_back = applied - (velocity - before) * self.rotor
        # The limiter reduces the effort to slow the joint, but the remaining effort
        # always supports the weight.
        if effort > gravity:
            room = (speed - velocity) * self.rotor + held_back
            return min(effort, max(room, min(0.0, gravity)))
        room = held_back - (speed + velocity) * self.rotor
        return max(effort, min(room, max(0.0, gravity)))
