"""Position and velocity interfaces, and the brake: servos on top of effort.

Gazebo's position interface teleports the joint unless gains are given; ours never
does.  Effort is gravity compensation plus a PD law on the joint's own inertia, so that
every joint answers alike whatever hangs on it, plus a slow integral against payloads.
"""

from __future__ import annotations

import math
from typing import final

from tool0.description.model import JointLimits, SafetyController
from tool0.hardware.limits import velocity_window

BANDWIDTH = 80.0
"""Natural frequency of a servo [rad/s]: 1 kHz steps are 12 times shorter."""
DAMPING_RATIO = 1.0
STIFF_BANDWIDTH = 200.0
"""The same where the inertia of a known rotor leads, whatever the joint carries: a
gripper squeezes with all its force from 5 mm on that are left to its target."""
STOPPED = 0.005
"""How far behind a stiff servo counts as stopped by something [rad | m]."""
INTEGRAL_RATE = 4.0
"""How fast a constant disturbance is taken over by the integral [1/s]."""
STANDSTILL = 0.02
"""Slowest motion that a brake does not call rest [rad/s | m/s]."""


@final
class PositionServo:
    """Drives one joint to a position, no faster than its limits allow."""

    def __init__(
        self,
        position: float,
        limits: JointLimits,
        soft: SafetyController | None = None,
        *,
        is_stiff: bool = False,
    ) -> None:
        self._limits = limits
        self._soft = soft
        self._is_stiff = is_stiff
        self._bandwidth = STIFF_BANDWIDTH if is_stiff else BANDWIDTH
        self._target = limits.clamp(position)
        self._integral = 0.0  # [1/s²], an acceleration
        self.speed = math.inf
        """Largest speed below the limits, as a goal may say [rad/s | m/s]."""

    def acceleration(
        self, command: float, position: float, velocity: float, dt: float
    ) -> float:
        """Return the acceleration for ``command`` [rad/s² | m/s²]."""
        previous = self._target
        lag = previous - position
        is_stopped = self._is_stiff and abs(lag) > STOPPED
        if is_stopped and (command - position) * lag < 0.0:
            previous = position  # to let go, it need not come back first
        slowest, fastest = velocity_window(previous, self._limits, self._soft)
        slowest, fastest = max(slowest, -self.speed), min(fastest, self.speed)
        step = min(max(command - previous, slowest * dt), fastest * dt)
        self._target = target = self._limits.clamp(previous + step)
        error = target - position
        stiffness = self._bandwidth**2
        if is_stopped:
            self._integral = 0.0  # an obstacle is no load
        else:
            self._integral += stiffness * INTEGRAL_RATE * error * dt
        speed_error = (target - previous) / dt - velocity
        return (
            stiffness * error
            + 2.0 * DAMPING_RATIO * self._bandwidth * speed_error
            + self._integral
        )


@final
class VelocityServo:
    """Drives one joint at a velocity."""

    def __init__(
        self, limits: JointLimits, soft: SafetyController | None = None
    ) -> None:
        self._limits = limits
        self._soft = soft
        self._integral = 0.0  # [rad/s² | m/s²]

    def acceleration(
        self, command: float, position: float, velocity: float, dt: float
    ) -> float:
        slowest, fastest = velocity_window(position, self._limits, self._soft)
        error = min(max(command, slowest), fastest) - velocity
        gain = 2.0 * DAMPING_RATIO * BANDWIDTH
        self._integral += gain * INTEGRAL_RATE * error * dt
        return gain * error + self._integral


@final
class Brake:
    """Slows one joint to rest and then keeps it where it came to rest."""

    def __init__(self) -> None:
        # With an integral: a payload must not keep the joint creeping.
        self._slow = VelocityServo(JointLimits())
        self._hold: tuple[PositionServo, float] | None = None

    def acceleration(
        self, command: float, position: float, velocity: float, dt: float
    ) -> float:
        """Return the braking acceleration [rad/s² | m/s²]; ``command`` is not read."""
        if self._hold is None:
            if abs(velocity) > STANDSTILL:
                return self._slow.acceleration(0.0, position, velocity, dt)
            self._hold = PositionServo(position, JointLimits()), position
        servo, held_at = self._hold
        return servo.acceleration(held_at, position, velocity, dt)


Servo = PositionServo | VelocityServo | Brake
