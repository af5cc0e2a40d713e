"""Conversion between simulated time and ROS time."""

import math
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock as ClockMessage

MAX_DRIFT = 0.05
"""Largest difference between two clocks before the offset is updated [s]."""
NANOSECONDS = 1_000_000_000


def to_seconds(stamp: Any) -> float:
    """Return a builtin_interfaces/Time or Duration in seconds."""
    seconds: float = stamp.sec + stamp.nanosec * 1e-9
    return seconds


class Clock:
    """Converts between simulated time and ROS time, and publishes /clock.

    Only one node in a domain publishes /clock.  A second bring-up follows the clock of
    the first bring-up.  The simulated time of the second bring-up differs from ROS time
    by an offset.
    """

    def __init__(self, node: Any) -> None:
        self._node = node
        self._offset = 0.0
        self._now = 0.0
        self._message = ClockMessage()
        self._publisher: Any = None
        self._subscription: Any = None
        self._publish()

    def advance(self, time: float) -> Time:
        """Set and publish the simulated time [s], and return it as ROS time."""
        self._now = time
        stamp = self.to_ros(time)
        publisher = self._publisher
        if publisher is not None:
            self._message.clock = stamp
            publisher.publish(self._message)
        return stamp

    def now(self) -> Time:
        """Return the ROS time of the last update."""
        return self.to_ros(self._now)

    def to_ros(self, time: float) -> Time:
        """Return simulated ``time`` [s] as ROS time."""
        whole, part = divmod(round((time + self._offset) * NANOSECONDS), NANOSECONDS)
        return Time(sec=max(0, whole), nanosec=part)

    def from_ros(self, stamp: Any) -> float | None:
        """Return a stamp as simulated time [s].  The result for 0 ("now") is None."""
        seconds = to_seconds(stamp)
        return seconds - self._offset if seconds else None

    def arbitrate(self) -> None:
        """Publish /clock if no other node publishes it.

        If another node also publishes /clock, the node with the later name in
        alphabetical order stops publishing /clock.

        Call this method in the thread of the executor.
        """
        own = self._node.get_fully_qualified_name()
        others = [
            f"{info.node_namespace.rstrip('/')}/{info.node_name}"
            for info in self._node.get_publishers_info_by_topic("/clock")
        ]
        others = [name for name in others if name != own]
        if self._publisher is None and not others:
            self._node.get_logger().warning("publishing /clock: no other node does")
            self._publish()
        elif self._publisher is not None and any(name < own for name in others):
            self._node.get_logger().warning(f"following the /clock of {min(others)}")
            self._follow()

    def close(self) -> None:
        """Stop publishing /clock."""
        self._publisher = None

    def _publish(self) -> None:
        subscription, self._subscription = self._subscription, None
        if subscription is not None:
            self._node.destroy_subscription(subscription)
        qos = QoSProfile(depth=10)
        self._publisher = self._node.create_publisher(ClockMessage, "/clock", qos)

    def _follow(self) -> None:
        publisher, self._publisher = self._publisher, None
        self._node.destroy_publisher(publisher)
        self._subscription = self._node.create_subscription(
            ClockMessage, "/clock", self._take, QoSProfile(depth=1)
        )

    def _take(self, message: Any) -> None:
        offset = to_seconds(message.clock) - self._now
        if not math.isclose(offset, self._offset, rel_tol=0.0, abs_tol=MAX_DRIFT):
            self._offset = offset
