"""Passes all states of a robot to its control boxes, in order.

If the process is late, it gets several states together.  Programs react only to the
newest one, but RTDE and the real-time interface send packets for each state, before any
reaction of a program.  The time for this is limited: a process that is permanently late
skips states, because its programs would fall further and further behind.
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
"""Time that may be spent at once on the states before the newest [wall s]; it suffices
for a quarter of a second of states, at 500 Hz for clients that read everything.  It
must not be longer, because clients that compute targets from the robot's time see that
time this much too late."""
SHARE: Final = 0.1
"""Fraction of the time that may be spent on these states permanently."""
_REPORT_PERIOD: Final = 10.0
"""Shortest time between two warnings [wall s]."""


@final
class Updates:
    """Passes states to control boxes."""

    def __init__(self, boxes: Sequence[UrControlBox]) -> None:
        """Keep a reference to the list, to which further boxes may be added."""
        self._boxes = boxes
        self._left, self._since = MOST_TIME, time.monotonic()
        """Time that may be spent [wall s], and the instant at which this was computed
        [wall s]."""
        self._n_left_out = 0
        """Number of skipped states since the last warning."""
        self._warned = -_REPORT_PERIOD

    def show(self, arrived: Sequence[Snapshot]) -> None:
        """Pass on the states that have arrived, oldest first; at least the newest."""
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
