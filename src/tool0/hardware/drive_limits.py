"""Limits of a drive's speed and effort below those of its joint, step by step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from tool0.description.model import JointLimits, ParallelGripper
from tool0.errors import ControlError

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

    def __init__(
        self,
        hard: JointLimits,
        *,
        armature: float,
        dt: float,
    ) -> None:
        """Begin with a rotor that nothing holds back.

        Args:
            hard: The joint's limits.
            armature: Inertia of the rotor as the joint feels it [kg·m²]; 0 if unknown.
            dt: Length of a step [s].
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
