"""Execution of program steps at exact intervals of simulated time."""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING, Final, final

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

CATCH_UP: Final = 0.1
"""If a step is late by at most this time, its interval starts at the end of the
previous interval [s]."""
AT_ONCE: Final = 0.02
"""Maximum time between two steps of a program that waits only for its intervals [s]."""
_ROUNDING: Final = 1e-9


@final
class Pacer:
    """Waits for consecutive intervals without gaps.

    Some programs, such as programs that follow splines, measure time in control
    periods. On a real robot, each step takes exactly one period. In tool0, the program
    and the simulation are separate processes, and the program may receive an update
    late. After a late update, the next steps of the program are shorter.
    """

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._due = -math.inf
        """Time at which the last interval should have ended [s]."""
        self._went_on = -math.inf
        """Time at which the program detected the end of the interval and continued
        [s]."""

    @property
    def start(self) -> float:
        """Start time of an interval that is requested now [s]."""
        now = self._box.time
        follows = 0.0 <= now - self._went_on <= AT_ONCE
        return self._due if follows and 0.0 <= now - self._due <= CATCH_UP else now

    async def wait(self, duration: float, *, is_scaled: bool = False) -> None:
        """Wait for a duration in simulated time [s]; a time reset ends the wait.

        If ``is_scaled`` is set, the speed scaling extends the wait.
        """
        box, start, left = self._box, self.start, duration
        is_over = False
        await asyncio.sleep(0)  # other tasks can run, even if the wait is over
        while not is_over:
            scale = box.state.speed_scaling if is_scaled else 1.0
            self._due = end = start + (left / scale if scale else math.inf)
            while not (is_over := not start <= box.time < end - _ROUNDING):
                await box.next_update()
                if is_scaled and box.state.speed_scaling != scale:
                    break
            left -= scale * (box.time - start)
            start = box.time
        self._went_on = box.time
