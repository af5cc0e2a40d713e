"""Streamed motions of an arm: position targets (servo) and velocities.

Each joint's acceleration is constant within a tick.  With constant accelerations,
position and velocity are continuous, and a ramp is exact at any control rate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, Protocol, final

from tool0.control.arm.model import ArmModel
from tool0.description.model import Joint
from tool0.protocol.state import ArmSetpoint

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SLOWING: Final = 4.0
"""Smallest acceleration with which velocities follow a reduced speed scaling [rad/s²],
so that even a stream with a small acceleration comes to rest when it is paused."""
MAX_ACCELERATION: Final = 40.0
"""Largest acceleration of a joint that follows a stream [rad/s²].  The value is from
ur_rtde (JOINT_ACCELERATION_MAX, https://sdurobotics.gitlab.io/ur_rtde/)."""
SINGULAR: Final = 0.02
"""Threshold of the Jacobian's smallest singular value below which joint velocities are
damped.  The value of a UR5e falls below the threshold 2 cm before its full reach, or
when its fifth joint is within 2 degrees of 0."""
_ROUNDING = 1e-9
"""Tolerance for rounding errors of times [s]."""


class StreamedMotion(Protocol):
    """A motion that is executed in Python in each tick, since it has no law."""

    @property
    def setpoint(self) -> ArmSetpoint:
        """The motion at the end of the last tick."""

    def advance(self, time: float, period: float, speed_scaling: float) -> None:
        """Advance the setpoint by one tick, which starts at ``time`` [s].

        ``speed_scaling`` is the control box's speed factor, 0 … 1.
        """


@final
class JointBounds:
    """Limits of an arm's joints that apply in a tick."""

    def __init__(self, joints: Sequence[Joint]) -> None:
        self._joints = [
            (
                joint.limits.lower,
                joint.limits.upper,
                joint.max_velocity,
                min(joint.max_acceleration, MAX_ACCELERATION),
            )
            for joint in joints
        ]

    def windows(
        self, q: Sequence[float], qd: Sequence[float], period: float, scale: float
    ) -> list[tuple[float, float]]:
        """Return the smallest and largest velocity of each joint after a tick.

        At a velocity in the returned range, a joint can still stop before its position
        limit without exceeding the acceleration limit of planned motions.  ``scale`` is
        a factor for the largest velocity.
        """
        found = []
        for (lower, upper, fastest, a), x, v in zip(self._joints, q, qd, strict=True):
            ahead = x + 0.5 * v * period
            most = min(scale * fastest, _fastest_before(upper - ahead, a, period))
            least = max(-scale * fastest, -_fastest_before(ahead - lower, a, period))
            found.append((least, most))
        return found


def _fastest_before(distance: float, a: float, period: float) -> float:
    """Return the largest velocity after a tick that allows a stop within ``distance``.

    A joint with velocity v that decelerates at ``a`` in each tick comes to rest within
    v² / 2a + a period² / 8.  The sum of the stopping distance and of the distance
    during the tick, v period / 2, must equal ``distance``.
    """
    if not distance > 0.0:
        return 0.0
    return max(0.0, math.sqrt(2.0 * a * distance) - 0.5 * a * period)


def _moved(now: ArmSetpoint, velocities: Sequence[float], period: float) -> ArmSetpoint:
    """Return the motion after a tick of constant acceleration to ``velocities``."""
    return ArmSetpoint(
        tuple(
            q + 0.5 * (v + w) * period
            for q, v, w in zip(now.positions, now.velocities, velocities, strict=True)
        ),
        tuple(velocities),
        tuple(
            (w - v) / period for v, w in zip(now.velocities, velocities, strict=True)
        ),
    )


@final
class ServoStream:
    """Follows the latest target, like ``servoj`` in URScript.

    The current position is extrapolated by ``lookahead_time`` with the current
    velocity.  The acceleration is ``gain`` times the distance from the extrapolated
    position to the target: qdd = gain (q_target - (q + lookahead_time qd)).
    """

    def __init__(self, start: ArmSetpoint, joints: Sequence[Joint]) -> None:
        self.setpoint = start
        self._bounds = JointBounds(joints)
        self._target = tuple(start.positions)
        self._lookahead_time, self._gain = 0.1, 300.0

    def aim(
        self, target: Sequence[float], *, lookahead_time: float, gain: float
    ) -> None:
        """Move to ``target`` [rad], starting now, and stay there."""
        self._target = tuple(target)
        self._lookahead_time, self._gain = lookahead_time, gain

    def advance(self, time: float, period: float, speed_scaling: float) -> None:
        q, qd, _ = self.setpoint
        windows = self._bounds.windows(q, qd, period, speed_scaling)
        change = MAX_ACCELERATION * period
        velocities = []
        for target, x, v, (least, most) in zip(
            self._target, q, qd, windows, strict=True
        ):
            a = self._gain * (target - (x + self._lookahead_time * v))
            wanted = min(max(v + a * period, least), most)
            velocities.append(min(max(wanted, v - change), v + change))
        self.setpoint = _moved(self.setpoint, velocities, period)


@final
class SpeedStream:
    """Moves with joint velocities (``speedj``) or with a tool twist (``speedl``).

    The velocity vector changes along a straight line; ``acceleration`` is the
    acceleration of the component that changes most.  Speed scaling slows down the clock
    of the stream: a scaling of 0.5 halves the velocities and quarters the
    accelerations.
    """

    def __init__(
        self, start: ArmSetpoint, joints: Sequence[Joint], model: ArmModel
    ) -> None:
        self.setpoint = start
        self._bounds = JointBounds(joints)
        self._model = model
        self._lever: Array | None = None
        """Position of the TCP in the flange frame [m]; None if joint velocities are
        given."""
        self._twist: Array | None = None
        """Twist of the TCP at the end of the last tick; None if it is unknown."""
        self._target: Sequence[float] = (0.0,) * len(joints)
        self._acceleration = 1.0
        self._ramp = math.inf
        """Duration of a ramp to rest from the last nonzero target [s]."""
        self._end = math.inf
        self._scale = 0.0
        """Speed scaling in the last tick."""
        self._is_slowing = False
        """Whether the velocity is still decreasing because of a reduced speed
        scaling."""

    def aim(
        self,
        target: Sequence[float],
        acceleration: float,
        *,
        until: float = math.inf,
        lever: Array | None = None,
    ) -> None:
        """Ramp to joint velocities [rad/s], or to a twist of the point at ``lever``.

        Args:
            target: The joint velocities [rad/s], or the twist in base axes [m/s,
                rad/s].
            acceleration: Acceleration [rad/s²], or [m/s², rad/s²].
            until: Time at which to ramp to rest [s].
            lever: Position of the point in the flange frame [m], shape (3,).
        """
        self._target, self._acceleration = tuple(target), acceleration
        largest = max(map(abs, target))
        if lever is not None:
            largest = max(math.hypot(*target[:3]), math.hypot(*target[3:]))
        if largest > 0.0:
            self._ramp = largest / acceleration
        self._end, self._lever, self._twist = until, lever, None

    def deceleration(self) -> float:
        """Return the equivalent deceleration of the leading joint [rad/s²].

        This deceleration stops the fastest joint within the duration of the ramp.  The
        deceleration is limited to ``MAX_ACCELERATION``.
        """
        leading = max(map(abs, self.setpoint.velocities))
        if not leading < MAX_ACCELERATION * self._ramp:
            return MAX_ACCELERATION
        return leading / self._ramp

    def advance(self, time: float, period: float, speed_scaling: float) -> None:
        is_over = time >= self._end - _ROUNDING
        scale = 0.0 if is_over else speed_scaling
        target = [scale * v for v in self._target]
        change = period * self._scaled_acceleration(speed_scaling, is_over=is_over)
        if self._lever is None:
            wanted = _ramped(self.setpoint.velocities, target, change)
            self._is_slowing &= wanted != target
            velocities = self._within(wanted, period)
        else:
            velocities = self._of_tool(target, self._lever, period, change)
        self.setpoint = _moved(self.setpoint, velocities, period)

    def _scaled_acceleration(self, speed_scaling: float, *, is_over: bool) -> float:
        """Return the acceleration in a tick.

        The acceleration of ramps to rest is not scaled.
        """
        self._is_slowing |= speed_scaling < self._scale
        self._scale = speed_scaling
        if is_over:
            return self._acceleration
        if self._is_slowing or not speed_scaling:
            return max(self._acceleration, SLOWING)
        return self._acceleration * speed_scaling**2

    def _of_tool(
        self, target: Sequence[float], lever: Array, period: float, most: float
    ) -> list[float]:
        """Return the joint velocities for one tick of a ramp of the tool's twist."""
        import numpy as np

        q, qd = (
            np.asarray(self.setpoint.positions),
            np.asarray(self.setpoint.velocities),
        )
        twist = self._twist
        if twist is None:
            twist = self._model.place(q, lever).jacobian @ qd
        change = np.asarray(target) - twist
        size = math.sqrt(max(change[:3] @ change[:3], change[3:] @ change[3:]))
        if size > most:
            change *= most / size
        else:
            self._is_slowing = False
        # The velocity of a tick is reached at the end of the tick.
        J = self._model.place(q + period * qd, lever).jacobian
        wanted: list[float] = damped_inverse(J, twist + change).tolist()
        velocities = self._within(wanted, period)
        self._twist = J @ np.asarray(velocities)
        return velocities

    def _within(self, wanted: Sequence[float], period: float) -> list[float]:
        """Return the velocities, scaled down jointly to meet the joint limits."""
        q, qd, _ = self.setpoint
        share = 1.0
        windows = self._bounds.windows(q, qd, period, 1.0)
        for v, (least, most) in zip(wanted, windows, strict=True):
            bound = most if v > 0.0 else least
            if v != 0.0 and abs(v) > abs(bound):
                share = min(share, bound / v)
        most = MAX_ACCELERATION * period
        return [
            min(max(share * w, v - most), v + most)
            for v, w in zip(qd, wanted, strict=True)
        ]


def damped_inverse(J: Array, twist: Array) -> Array:
    """Return the joint velocities for a twist, which are damped near singularities.

    The method is damped least squares.  The damping factor grows as the smallest
    singular value falls below ``SINGULAR`` (Maciejewski and Klein 1988,
    https://doi.org/10.1002/rob.4620050603).
    """
    import numpy as np

    U, sizes, V = np.linalg.svd(J)
    smallest = float(sizes[-1])
    damping = 0.0
    if smallest < SINGULAR:
        damping = (1.0 - (smallest / SINGULAR) ** 2) * SINGULAR**2
    return np.asarray(V.T @ (sizes / (sizes**2 + damping) * (U.T @ twist)))


def _ramped(now: Sequence[float], target: Sequence[float], most: float) -> list[float]:
    """Return velocities after a tick; no velocity changes by more than ``most``."""
    changes = [w - v for v, w in zip(now, target, strict=True)]
    largest = max(map(abs, changes))
    if not largest > most:
        return list(target)
    share = most / largest
    return [v + share * change for v, change in zip(now, changes, strict=True)]
