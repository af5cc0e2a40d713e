"""Shows the states of a robot to its control boxes, all of them and in order.

A process that was late gets several states together.  Programs act on the newest one
only, but what is sent at every update (RTDE, the real-time interface) is sent for each,
before anything that a program answers.  That takes time, so it is limited: a process
that is late for good leaves states out, as its programs would come later and later.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from typing import Final, final

from tool0.protocol.state import Snapshot
from tool0.ur.control_box import UrControlBox

logger = logging.getLogger(__name__)

MOST_TIME: Final = 0.05
"""Time that may be spent at once on the states before the newest [wall s]: a quarter of
a second of them, at 500 Hz for clients that read everything.  Who sends targets by the
robot's time aims that much too early, so that it must not be longer."""
SHARE: Final = 0.1
"""Part of the time that may be spent on them for long."""
_REPORT_PERIOD: Final = 10.0
"""Pause between two warnings [wall s]."""


@final
class Updates:
    """Shows states to control boxes."""

    def __init__(self, boxes: Sequence[UrControlBox]) -> None:
        """Show nothing yet; further boxes may be added to the list."""
        self._boxes = boxes
        self._left, self._since = MOST_TIME, time.monotonic()
        """Time that may be spent [wall s], as it was at an instant [wall s]."""
        self._n_left_out = 0
        """States since the last warning."""
        self._warned = -_REPORT_PERIOD

    def show(self, arrived: Sequence[Snapshot]) -> None:
        """Show the states that have arrived, oldest first; at least the newest."""
        *passed, newest = arrived
        if passed:
            self._show_passed(passed)
        for box in self._boxes:
            box.take(newest)

    def _show_passed(self, passed: Sequence[Snapshot]) -> None:
        now = time.monotonic()
        left = min(MOST_TIME, self._left + SHARE * (now - self._since))
        end, n_shown = now + left, 0
        for snapshot in passed:
            if time.monotonic() >= end:
                break
            for box in self._boxes:
                box.show(snapshot)
            n_shown += 1
        self._since = time.monotonic()
        self._left = end - self._since
        self._report(len(passed) - n_shown)

    def _report(self, n_left_out: int) -> None:
        self._n_left_out += n_left_out
        if self._n_left_out and self._since - self._warned >= _REPORT_PERIOD:
            logger.warning(
                "%d states were left out: this process has too little processor time "
                "for all clients of RTDE and the real-time interface",
                self._n_left_out,
            )
            self._n_left_out, self._warned = 0, self._since
