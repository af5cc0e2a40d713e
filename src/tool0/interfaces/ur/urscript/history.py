"""What the arm did in the last second, for functions that look back."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple, final

from tool0.interfaces.ur.urscript.errors import ValueProblem
from tool0.requests.updates import Six

if TYPE_CHECKING:
    from tool0.interfaces.ur.urscript.robot import Robot

DURATION: Final = 1.0
"""Longest look back [s]."""
STEADY: Final = 0.5
"""Time at rest after which the arm is steady [s], as on the robot."""
CONTACT: Final = 5.0
"""Force against the motion that is a contact [N]."""
TOUCH: Final = 1.0
"""Force against the motion from which on the contact is counted [N]."""
_AT_REST: Final = 1e-9
"""Velocity of the setpoint [rad/s]."""
_SHORT: Final = 1e-6
"""[s]"""


class Sample(NamedTuple):
    """The arm in one control period."""

    time: float
    """[s]"""
    q: Six
    """[rad]"""
    force: tuple[float, float, float]
    """At the flange, in its axes [N]."""


@final
class History:
    """Samples of each control period, from the start of the program on."""

    def __init__(self, robot: Robot) -> None:
        """Record the updates of a robot."""
        self._robot = robot
        self._period = 1.0 / robot.rate
        self._samples: deque[Sample] = deque(maxlen=round(DURATION * robot.rate))
        self._moved_at = robot.time
        self._record()
        robot.when_updated.add(self._record)

    def close(self) -> None:
        """Record no further updates."""
        self._robot.when_updated.discard(self._record)

    def _record(self) -> None:
        robot = self._robot
        if any(abs(x) > _AT_REST for x in robot.arm_update.target_velocity):
            self._moved_at = robot.time
        if self._samples:
            passed = robot.time - self._samples[-1].time
            if passed < 0.0:
                self._samples.clear()
                self._moved_at = robot.time
            elif passed < self._period - _SHORT:
                return
        x, y, z, *_ = robot.arm_update.wrench
        self._samples.append(Sample(robot.time, robot.q, (x, y, z)))

    def sample(self, steps: int) -> Sample:
        """Return what was some control periods ago."""
        if not 0 <= steps < len(self._samples):
            raise ValueProblem(
                f"{steps} steps back; {len(self._samples)} are recorded so far"
            )
        return self._samples[-1 - steps]

    @property
    def is_steady(self) -> bool:
        """Whether the arm has been at rest for half a second."""
        return self._robot.time - self._moved_at >= STEADY

    def contact(self, motion: Sequence[float]) -> int:
        """Return since how many control periods something pushes against a motion.

        Args:
            motion: Direction in the flange's axes; zeros stand for any.
        """
        length = math.hypot(*motion)

        def against(sample: Sample) -> float:
            if length < _AT_REST:
                return math.hypot(*sample.force)
            pairs = zip(motion, sample.force, strict=True)
            return -sum(a * b for a, b in pairs) / length

        if against(self._samples[-1]) < CONTACT:
            return 0
        steps = 0
        for sample in reversed(self._samples):
            if against(sample) < TOUCH:
                break
            steps += 1
        return min(steps, len(self._samples) - 1) or 1
