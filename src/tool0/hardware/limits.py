"""Limits of joints as ros_control enforces them, and lower ones of a goal's drive.

Saturation is that of joint_limits_interface (ros_control noetic,
``joint_limits_interface.h``), ``EffortJointSaturationHandle`` and
``EffortJointSoftLimitsHandle``: the effort is clamped, a joint beyond a position limit
gets no effort outwards, one beyond its speed no effort that drives it on.  Two things
differ, on purpose:

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

from tool0.description.model import JointLimits, ParallelGripper, SafetyController
from tool0.errors import ControlError
from tool0.hardware.engine import JointState

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


EASE = 0.05
"""Shortest time in which a drive lets go of all its effort when its limits get lower
[s]: several times the 13 ms at which rotor and pads swing on what they squeeze, so that
a weaker grip stays a grip.  A guess: no datasheet tells a 2F-85's."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DriveLimits:
    """Speed and force that a goal allows a gripper, as rSP and rFR of a real 2F-85 do.

    Speed and force are those of the pads, so that the joint's limits follow from its
    position: ``velocity = speed / lever``, ``effort = force · lever``.

    Raises:
        ControlError: If a value is beyond what the gripper can do.
    """

    gripper: ParallelGripper
    speed: float | None = None
    """Of the pads towards each other [m/s]; None for the joint's limit."""
    force: float | None = None
    """At each pad [N]; None for the joint's limit."""
    effort: float | None = None
    """Instead of a force: torque of the driven joint [N·m]."""

    def __post_init__(self) -> None:
        if self.force is not None and self.effort is not None:
            raise ControlError(
                f"give a force ({self.force} N) or an effort ({self.effort} N·m), "
                "not both"
            )
        _check("speed", self.speed, self.gripper.speed, "m/s")
        _check("force", self.force, self.gripper.force, "N")
        if self.effort is not None and not 0.0 < self.effort < math.inf:
            raise ControlError(f"effort must be above 0 and finite, got {self.effort}")

    def at(self, position: float) -> tuple[float, float]:
        """Return the largest effort [N·m] and velocity [rad/s] at ``position``."""
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


@final
class SpeedLimiter:
    """Bounds the effort of one drive so that it keeps to its speed.

    A rotor of known inertia gets no more effort than takes it to the largest speed
    within the step, beyond what held it back during the last one.  So it keeps the
    speed against friction, does not run above it when it comes free, and presses with
    all its effort where something stops it.
    """

    def __init__(self, hard: JointLimits, *, armature: float, dt: float) -> None:
        """Begin with a rotor that nothing holds back.

        ``armature`` is its inertia as the joint feels it [kg·m²], 0 if unknown; ``dt``
        [s] the length of a step.
        """
        self._effort = hard.effort
        self._speed = hard.velocity
        self._rotor = armature / dt if armature > 0.0 else math.inf
        self._ease = hard.effort * dt / EASE
        self._velocity: float | None = None
        self.drive_limits: DriveLimits | None = None
        """Of the goal; None for the joint's own."""

    def limit(
        self,
        effort: float,
        applied: float,
        gravity: float,
        position: float,
        velocity: float,
    ) -> float:
        """Return ``effort`` [N·m | N] as far as it is allowed.

        Args:
            effort: What is wanted.
            applied: What was applied during the last step.
            gravity: The part of ``effort`` that compensates gravity, which the limits
                of a goal do not count.
            position: Of the joint [rad | m].
            velocity: Of the joint [rad/s | m/s].
        """
        most, speed = self._effort, self._speed
        if (
            self.drive_limits is None
            and -most <= effort <= most
            and abs(velocity) + abs(effort) / self._rotor <= speed
        ):
            self._velocity = None
            return effort  # as nearly always: nothing binds
        if self.drive_limits is not None:
            grip, fastest = self.drive_limits.at(position)
            # What squeezes with more lets go step by step.
            lowest = min(gravity - grip, applied + self._ease)
            highest = max(gravity + grip, applied - self._ease)
            effort = min(max(effort, lowest), highest)
            speed = min(speed, fastest)
        effort = min(max(effort, -most), most)
        before, self._velocity = self._velocity, velocity
        if self._rotor == math.inf:
            is_too_fast = velocity > speed if effort > 0.0 else velocity < -speed
            return 0.0 if is_too_fast else effort
        held_back = 0.0
        if before is not None:
            held_back = applied - (velocity - before) * self._rotor
        # To slow down, it lets go, but it never drops the weight.
        if effort > gravity:
            room = (speed - velocity) * self._rotor + held_back
            return min(effort, max(room, min(0.0, gravity)))
        room = held_back - (speed + velocity) * self._rotor
        return max(effort, min(room, max(0.0, gravity)))
