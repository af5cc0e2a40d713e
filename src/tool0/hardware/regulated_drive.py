"""A drive that keeps to a speed: by its rotor's inertia, and by a goal's settings."""

from __future__ import annotations

import math
from typing import final

from tool0.description.model import JointLimits
from tool0.hardware.drive_bounds import DriveBounds

EASE = 0.05
"""How long a drive takes at least to let go of all its effort when its settings get
weaker [s]: several times the 13 ms at which rotor and pads swing on what they squeeze,
so that a weaker grip stays a grip.  A guess: no datasheet tells a 2F-85's."""


@final
class RegulatedDrive:
    """Bounds the effort of one joint, knowing how its rotor answered the last step.

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
        self.bounds: DriveBounds | None = None
        """What is allowed below the limits."""

    def bound(
        self,
        effort: float,
        applied: float,
        load: float,
        position: float,
        velocity: float,
    ) -> float:
        """Return ``effort`` [N·m | N] as far as it is allowed.

        Args:
            effort: What is wanted.
            applied: What was applied during the last step.
            load: What of ``effort`` carries the weight: settings do not count it.
            position: Of the joint [rad | m].
            velocity: Of the joint [rad/s | m/s].
        """
        most, speed = self._effort, self._speed
        if (
            self.bounds is None
            and -most <= effort <= most
            and abs(velocity) + abs(effort) / self._rotor <= speed
        ):
            self._velocity = None
            return effort  # as nearly always: nothing binds
        if self.bounds is not None:
            grip, fastest = self.bounds.at(position)
            # What squeezes with more lets go step by step.
            lowest = min(load - grip, applied + self._ease)
            highest = max(load + grip, applied - self._ease)
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
        # To slow down, it lets go, but never of the weight.
        if effort > load:
            room = (speed - velocity) * self._rotor + held_back
            return min(effort, max(room, min(0.0, load)))
        room = held_back - (speed + velocity) * self._rotor
        return max(effort, min(room, max(0.0, load)))
