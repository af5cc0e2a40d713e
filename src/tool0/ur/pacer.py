"""Steps of a program at exact intervals of simulated time."""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING, Final, final

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

CATCH_UP: Final = 0.02
"""How late a step may begin and still count from when it was due [s]."""


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
        """When the last interval ended [s]."""

    async def wait(self, duration: float) -> None:
        """Wait for simulated time to pass [s]; a reset of the time ends it."""
        now = self._box.time
        start = self._due if 0.0 <= now - self._due <= CATCH_UP else now
        self._due = end = start + duration
        await asyncio.sleep(0)  # others have their turn, also if it is over already
        await self._box.until(lambda: not start <= self._box.time < end - 1e-9)
