"""Detection of tool contacts for ``tool_contact``, and storage of past positions.

UR does not publish the criterion for a contact. In tool0, a contact is an external
force at the tool of at least ``CONTACT_FORCE``. The contact starts when the force
exceeds ``START_FORCE``.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple, final

from tool0.protocol.state import Six

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

CONTACT_FORCE: Final = 5.0
"""Minimum force of a contact, opposite to the monitored direction [N]."""
START_FORCE: Final = 1.0
"""Force above which a contact has started [N]."""
MAX_STEPS: Final = 500
"""Number of updates for which the positions are stored."""
STEADY_TIME: Final = 0.5
"""Time at rest after which the arm is considered steady [s]."""
STEADY_SPEED: Final = 1e-3
"""Maximum speed of each joint of a steady arm [rad/s]."""


class _Moment(NamedTuple):
    time: float
    q: Six
    qd: Six
    force: tuple[float, float, float]
    """External force in the flange's axes [N]."""
    is_resting: bool


@final
class ToolHistory:
    """A context manager that records an arm's state at the last updates."""

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._moments: deque[_Moment] = deque(maxlen=MAX_STEPS)

    def __enter__(self) -> ToolHistory:
        self._record()
        self._box.when_updated.add(self._record)
        return self

    def __exit__(self, *_: object) -> None:
        self._box.when_updated.discard(self._record)

    def positions(self, steps: int) -> Six:
        """Return the joint positions of an earlier update, or the oldest ones [rad]."""
        index = min(max(steps, 0), len(self._moments) - 1)
        return self._moments[-1 - index].q

    def accelerations(self) -> Six:
        """Return the joint accelerations between the last two updates [rad/s²]."""
        if len(self._moments) < 2:
            return (0.0,) * 6
        before, now = self._moments[-2], self._moments[-1]
        period = now.time - before.time
        a, b, c, d, e, f = (
            (x - y) / period for x, y in zip(now.qd, before.qd, strict=True)
        )
        return (a, b, c, d, e, f)

    def contact(self, direction: Sequence[float]) -> int:
        """Return the number of updates since a contact started; 0 without a contact.

        Args:
            direction: Direction in which the tool approaches objects, in the base
                frame's axes. The vector may have any length; zero stands for all
                directions.
        """
        first = self._force_along(self._moments[-1], direction)
        if first < CONTACT_FORCE:
            return 0
        steps = 0
        for moment in reversed(self._moments):
            if self._force_along(moment, direction) < START_FORCE:
                break
            steps += 1
        return steps

    def is_steady(self) -> bool:
        """Return whether the arm has been at rest for ``STEADY_TIME``."""
        now = self._moments[-1].time
        for moment in reversed(self._moments):
            if not moment.is_resting:
                return False
            if now - moment.time >= STEADY_TIME - 1e-9:
                return True
        return False

    def _record(self) -> None:
        box = self._box
        if self._moments and box.time < self._moments[-1].time:
            self._moments.clear()  # the time was reset
        fx, fy, fz = box.sensed_wrench[:3]
        is_resting = max(map(abs, box.qd)) <= STEADY_SPEED
        self._moments.append(_Moment(box.time, box.q, box.qd, (fx, fy, fz), is_resting))

    def _force_along(self, moment: _Moment, direction: Sequence[float]) -> float:
        """Return the component of the force that opposes motion in a direction [N].

        The current orientation of the flange is used, because it hardly changes while
        the arm approaches a contact.
        """
        if not any(direction[:3]):
            return math.hypot(*moment.force)
        force = self._box.posture().flange.rotate(moment.force)
        along = sum(f * d for f, d in zip(force, direction[:3], strict=True))
        return -along / math.hypot(*direction[:3])
