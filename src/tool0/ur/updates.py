"""Passes all states of a robot to its control boxes, in order.

If the process is delayed, it receives several states together. Programs react only to
the newest state. RTDE and the real-time interface send packets for each state before
any program reacts. The time for sending packets of older states is limited. A process
that is permanently too slow skips states, because the delay of its programs would
otherwise increase without limit.
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
"""Maximum time that is spent consecutively on the states before the newest state [wall
s]. The time is sufficient for the states of a quarter of a second at 500 Hz if the
clients read everything. A longer time would be a disadvantage for clients that compute
targets from the robot's time, because they receive this time with the same delay."""
SHARE: Final = 0.1
"""Maximum fraction of time that is permanently spent on the states before the newest
state."""
_REPORT_PERIOD: Final = 10.0
"""Minimum time between two warnings [wall s]."""


@final
class Updates:
    """Passes states to control boxes."""

    def __init__(self, boxes: Sequence[UrControlBox]) -> None:
        """Keep a reference to the list; boxes may be added to the list later."""
        self._boxes = boxes
        self._left, self._since = MOST_TIME, time.monotonic()
        """Remaining time that may be spent [wall s], and the time at which this value
        was computed [wall s]."""
        self._n_left_out = 0
        """Number of skipped states since the last warning."""
        self._warned = -_REPORT_PERIOD

    def show(self, arrived: Sequence[Snapshot]) -> None:
        """Pass on received states, oldest first; always pass on the newest state."""
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
