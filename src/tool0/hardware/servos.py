"""Servos, which compute the acceleration of one joint toward its command."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple, final

from tool0.description.model import JointLimits, SafetyController
from tool0.hardware.limits import velocity_window

BANDWIDTH = 80.0
"""Natural frequency of a servo [rad/s].  The time constant is 12 steps of 1 ms."""
DAMPING_RATIO = 1.0
STIFF_BANDWIDTH = 200.0
"""Natural frequency of a servo whose inertia is mainly a known rotor inertia, whatever
the load [rad/s].  A gripper grips with its full force if it is stopped 5 mm or more
from its target."""
STOPPED = 0.005
"""Lag above which a stiff servo is considered blocked [rad | m]."""
INTEGRAL_RATE = 4.0
"""Rate at which the integral compensates a constant disturbance [1/s]."""
BLOCKED = 0.02
"""Lag at a standstill above which any servo is considered blocked [rad | m].  A load
causes a smaller lag."""
STANDSTILL = 0.02
"""Velocity below which a lagging joint is considered blocked [rad/s | m/s]."""


class ServoKind(IntEnum):
    """The kinds of servos."""

    POSITION = 0
    """Servo that moves the joint to the position that the controller commands."""
    VELOCITY = 1
    """Servo that moves the joint at the velocity that the controller commands."""


class ServoLaw(NamedTuple):
    """The constants of a servo."""

    kind: ServoKind
    limits: JointLimits
    soft: SafetyController | None
    is_stiff: bool = False
    integral_rate: float = INTEGRAL_RATE
    """Rate at which the integral compensates a constant disturbance [1/s]."""


class ServoState(NamedTuple):
    """Values that a servo keeps from one step to the next."""

    target: float
    """Position that the servo tracks, which moves within the speed limit [rad | m].
    For a velocity servo, the value is 0."""
    integral: float
    """Integral of the error, as an acceleration [rad/s² | m/s²]."""
    speed: float
    """Speed limit set by a goal [rad/s | m/s]; infinite for a velocity servo."""


@final
class PositionServo:
    """Moves one joint to a position within the joint's speed limit."""

    def __init__(
        self,
        position: float,
        limits: JointLimits,
        soft: SafetyController | None = None,
        *,
        is_stiff: bool = False,
        integral_rate: float = INTEGRAL_RATE,
    ) -> None:
        self.law = ServoLaw(ServoKind.POSITION, limits, soft, is_stiff, integral_rate)
        self._integral_rate = integral_rate
        self._limits = limits
        self._soft = soft
        self._is_stiff = is_stiff
        self._bandwidth = STIFF_BANDWIDTH if is_stiff else BANDWIDTH
        self._target = limits.clamp(position)
        self._integral = 0.0  # acceleration [rad/s² | m/s²]
        self.speed = math.inf
        """Speed limit set by a goal, in addition to the joint's speed limit
        [rad/s | m/s]."""

    @property
    def state(self) -> ServoState:
        """Values that the servo keeps from one step to the next."""
        return ServoState(self._target, self._integral, self.speed)

    def restore(self, state: ServoState) -> None:
        """Continue from ``state``."""
        self._target, self._integral, self.speed = state

    def acceleration(
        self, command: float, position: float, velocity: float, dt: float, left: int
    ) -> float:
        """Return the acceleration for ``command`` [rad/s² | m/s²].

        The target reaches ``command`` in ``left`` steps, when the next command is due.
        Between commands, the joint moves at constant velocity.
        """
        previous = self._target
        lag = previous - position
        is_stopped = self._is_stiff and abs(lag) > STOPPED
        if is_stopped and (command - position) * lag < 0.0:
            previous = position  # release without waiting for the joint to return
        slowest, fastest = velocity_window(previous, self._limits, self._soft)
        slowest, fastest = max(slowest, -self.speed), min(fastest, self.speed)
        step = min(max((command - previous) / left, slowest * dt), fastest * dt)
        self._target = target = self._limits.clamp(previous + step)
        error = target - position
        stiffness = self._bandwidth**2
        is_blocked = abs(lag) > BLOCKED and abs(velocity) < STANDSTILL
        if is_stopped or is_blocked:
            self._integral = 0.0  # an obstacle must not be compensated like a load
        else:
            self._integral += stiffness * self._integral_rate * error * dt
        speed_error = (target - previous) / dt - velocity
        return (
            stiffness * error
            + 2.0 * DAMPING_RATIO * self._bandwidth * speed_error
            + self._integral
        )


@final
class VelocityServo:
    """Moves one joint at a velocity."""

    def __init__(
        self, limits: JointLimits, soft: SafetyController | None = None
    ) -> None:
        self.law = ServoLaw(ServoKind.VELOCITY, limits, soft)
        self._limits = limits
        self._soft = soft
        self._integral = 0.0  # [rad/s² | m/s²]

    @property
    def state(self) -> ServoState:
        """Values that the servo keeps from one step to the next."""
        return ServoState(0.0, self._integral, math.inf)

    def restore(self, state: ServoState) -> None:
        """Continue from ``state``."""
        self._integral = state.integral

    def acceleration(
        self, command: float, position: float, velocity: float, dt: float, left: int
    ) -> float:
        slowest, fastest = velocity_window(position, self._limits, self._soft)
        error = min(max(command, slowest), fastest) - velocity
        gain = 2.0 * DAMPING_RATIO * BANDWIDTH
        self._integral += gain * INTEGRAL_RATE * error * dt
        return gain * error + self._integral


Servo = PositionServo | VelocityServo


def servo_of(law: ServoLaw) -> Servo:
    """Return a servo with this law.  The caller must restore the servo's state."""
    if law.kind is ServoKind.POSITION:
        return PositionServo(
            0.0,
            law.limits,
            law.soft,
            is_stiff=law.is_stiff,
            integral_rate=law.integral_rate,
        )
    return VelocityServo(law.limits, law.soft)
