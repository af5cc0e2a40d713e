"""Steps of a program at exact intervals of simulated time."""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING, Final, final

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

CATCH_UP: Final = 0.1
"""Longest delay with which a step begins and still counts from when it was due [s]."""
AT_ONCE: Final = 0.02
"""Time within which a program continues after a step, if it waits for nothing else
[s]."""
_ROUNDING: Final = 1e-9


@final
class Pacer:
    """Waits for intervals that follow each other without gaps.

    Programs count their time in steps of the control period, as those with splines do.
    On a robot, each step takes exactly as long.  Here, the program is another process
    than the simulation, and may see an update late: its next steps are shorter then.
    """

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._due = -math.inf
        """Time at which the last interval ended [s]."""
        self._went_on = -math.inf
        """Time at which the program saw that, and continued [s]."""

    @property
    def start(self) -> float:
        """Time at which the interval that is waited for now begins [s]."""
        now = self._box.time
        follows = 0.0 <= now - self._went_on <= AT_ONCE
        return self._due if follows and 0.0 <= now - self._due <= CATCH_UP else now

    async def wait(self, duration: float, *, is_scaled: bool = False) -> None:
        """Wait for simulated time to pass [s]; a reset of the time ends it.

        The speed scaling slows it down if it ``is_scaled``.
        """
        box, start, left = self._box, self.start, duration
        is_over = False
        await asyncio.sleep(0)  # others have their turn, also if it is over already
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
