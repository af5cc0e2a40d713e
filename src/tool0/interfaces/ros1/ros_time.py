"""Simulated time in ROS: the clock we publish, or another robot's that we follow."""

from __future__ import annotations

import logging
import math
import threading
from typing import Any, final

logger = logging.getLogger(__name__)

SLACK = 0.05
"""By how much two clocks may drift apart before we follow anew [s]; each tells of
itself every 8 ms."""


@final
class RosTime:
    """Relates simulated time to ROS's.

    The first bring-up under a master publishes /clock.  A second one, with a namespace
    of its own, lives in the first one's time: its own differs by an offset.
    """

    def __init__(self, *, is_ours: bool) -> None:
        from rosgraph_msgs.msg import Clock
        from rospy import Publisher, Subscriber
        from rospy.rostime import (
            _set_rostime,
            set_rostime_initialized,
        )

        self._message = Clock
        self._set_ours = _set_rostime  # what its own subscriber to /clock would call
        self._offset = 0.0
        self._now = 0.0
        self._publisher: Any = None
        self._changing = threading.Lock()  # who publishes, between two looks at it
        self._subscriber: Any = None
        self._publisher_of = Publisher
        set_rostime_initialized(True)
        self._subscriber_to = Subscriber
        if is_ours:
            self.take_over()
        else:
            self.give_up()

    @property
    def is_ours(self) -> bool:
        """Whether /clock is published by us."""
        return self._publisher is not None

    def give_up(self) -> None:
        """Follow another's /clock from now on."""
        with self._changing:
            publisher, self._publisher = self._publisher, None
        if publisher is not None:
            publisher.unregister()
        self._subscriber = self._subscriber_to(
            "/clock", self._message, self._follow, queue_size=1
        )

    def take_over(self) -> None:
        """Publish /clock from now on; it goes on from where it is."""
        if self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None
        self._publisher = self._publisher_of("/clock", self._message, queue_size=100)

    def advance(self, time: float) -> None:
        """Say that it is ``time`` [s] in the simulation."""
        self._now = time
        now = self.to_ros(time)
        self._set_ours(now)
        with self._changing:
            if self._publisher is not None:
                self._publisher.publish(self._message(clock=now))

    def to_ros(self, time: float) -> Any:  # a rospy.Time
        """Return simulated ``time`` [s] as ROS stamps it."""
        from rospy import Time

        nanoseconds = max(0, round((time + self._offset) * 1e9))
        return Time(*divmod(nanoseconds, 1_000_000_000))

    def from_ros(self, stamp: Any) -> float | None:
        """Return a stamp as simulated time [s]; None for 0, which means now."""
        seconds: float = stamp.to_sec()
        return seconds - self._offset if seconds else None

    def _follow(self, message: Any) -> None:
        offset = message.clock.to_sec() - self._now
        if not math.isclose(offset, self._offset, rel_tol=0.0, abs_tol=SLACK):
            self._offset = offset
