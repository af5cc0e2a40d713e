"""Simulated time in ROS: the /clock that we publish, or another robot's."""

from __future__ import annotations

import math
import threading
from typing import Any, final

from rosgraph_msgs.msg import Clock
from rospy import Publisher, Subscriber, Time
from rospy.rostime import _set_rostime, set_rostime_initialized

MAX_DRIFT = 0.05
"""Largest difference between two clocks before the offset is set again [s]; each is
published every 8 ms."""


@final
class RosClock:
    """Converts between simulated time and ROS time.

    The first bring-up under a master publishes /clock.  A second one, with a namespace
    of its own, follows it: its simulated time differs from ROS time by an offset.
    """

    def __init__(self, *, publish: bool) -> None:
        self._offset = 0.0
        self._now = 0.0
        self._publisher: Any = None
        self._subscriber: Any = None
        self._lock = threading.Lock()  # no message after the publisher has ended
        set_rostime_initialized(True)
        if publish:
            self.start_publishing()
        else:
            self.follow_other()

    @property
    def is_publisher(self) -> bool:
        """Whether we publish /clock."""
        return self._publisher is not None

    def follow_other(self) -> None:
        """Follow another node's /clock from now on."""
        with self._lock:
            publisher, self._publisher = self._publisher, None
        if publisher is not None:
            publisher.unregister()
        self._subscriber = Subscriber("/clock", Clock, self._follow, queue_size=1)

    def start_publishing(self) -> None:
        """Publish /clock from now on; it continues from the present ROS time."""
        if self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None
        self._publisher = Publisher("/clock", Clock, queue_size=100)

    def advance(self, time: float) -> None:
        """Set the simulated time [s]."""
        self._now = time
        now = self.to_ros(time)
        _set_rostime(now)
        with self._lock:
            if self._publisher is not None:
                self._publisher.publish(Clock(clock=now))

    def to_ros(self, time: float) -> Any:  # a rospy.Time
        """Return simulated ``time`` [s] as ROS time."""
        nanoseconds = max(0, round((time + self._offset) * 1e9))
        return Time(*divmod(nanoseconds, 1_000_000_000))

    def from_ros(self, stamp: Any) -> float | None:
        """Return a stamp as simulated time [s]; None for 0, which means now."""
        seconds: float = stamp.to_sec()
        return seconds - self._offset if seconds else None

    def _follow(self, message: Any) -> None:
        offset = message.clock.to_sec() - self._now
        if not math.isclose(offset, self._offset, rel_tol=0.0, abs_tol=MAX_DRIFT):
            self._offset = offset
