"""The ROS node of a bring-up: its name, clock, topics, services and log."""

from __future__ import annotations

import contextlib
import logging
import math
import os
import queue
import threading
import time
from collections.abc import Callable
from importlib import resources
from typing import Any, Protocol, final
from xmlrpc.client import ServerProxy

import rospy
from rosgraph_msgs.msg import Clock
from rospy import Publisher, Subscriber, Time, core, names
from rospy.impl.registration import get_service_manager, get_topic_manager
from rospy.rostime import _set_rostime, set_rostime_initialized

from tool0.errors import RosUnavailableError
from tool0.installation.ros1.master import Master
from tool0.protocol.state import Snapshot
from tool0.ros1.options import NODE_NAME, Ros1Options

logger = logging.getLogger(__name__)

MAX_DRIFT = 0.05
"""Largest difference between two clocks before the offset is updated [s].  Each clock
is published every 8 ms."""


@final
class RosClock:
    """Converts between simulated time and ROS time.

    The first bring-up that registers with a master publishes /clock.  A second
    bring-up, in another namespace, follows the clock of the first bring-up.  The
    simulated time of the second bring-up differs from ROS time by an offset.
    """

    def __init__(self, *, publish: bool) -> None:
        self._offset = 0.0
        self._now = 0.0
        self._publisher: Any = None
        self._subscriber: Any = None
        # prevents a message after the publisher has ended
        self._lock = threading.Lock()
        set_rostime_initialized(True)
        if publish:
            self.start_publishing()
        else:
            self.follow_other()

    @property
    def is_publisher(self) -> bool:
        """Whether this node publishes /clock."""
        return self._publisher is not None

    def follow_other(self) -> None:
        """Stop publishing /clock, and follow the /clock of another node."""
        with self._lock:
            publisher, self._publisher = self._publisher, None
        if publisher is not None:
            publisher.unregister()
        self._subscriber = Subscriber("/clock", Clock, self._follow, queue_size=1)

    def start_publishing(self) -> None:
        """Start to publish /clock.  The clock continues from the current ROS time."""
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

    def to_ros(self, time: float) -> Any:  # Any: a rospy.Time
        """Return simulated ``time`` [s] as ROS time."""
        nanoseconds = max(0, round((time + self._offset) * 1e9))
        return Time(*divmod(nanoseconds, 1_000_000_000))

    def from_ros(self, stamp: Any) -> float | None:
        """Return a stamp as simulated time [s].  The result for 0 ("now") is None."""
        seconds: float = stamp.to_sec()
        return seconds - self._offset if seconds else None

    def _follow(self, message: Any) -> None:
        offset = message.clock.to_sec() - self._now
        if not math.isclose(offset, self._offset, rel_tol=0.0, abs_tol=MAX_DRIFT):
            self._offset = offset


_REPEAT_PERIOD = 1.0
"""Interval at which a repeated error is logged again [wall s]."""


class SnapshotPublisher(Protocol):
    """Publisher of one part of each snapshot; only one thread may use it."""

    def publish(self, snapshot: Snapshot) -> None:
        """Publish the messages that are due.  Simulated time may have been reset."""

    def close(self) -> None:
        """Unregister the publisher's topics and services."""


@final
class WorkerThread:
    """A thread that runs tasks in order."""

    def __init__(self, name: str) -> None:
        self._tasks: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, task: Callable[[], None]) -> None:
        """Add ``task`` to the queue without waiting."""
        self._tasks.put(task)

    def close(self, timeout: float = 1.0) -> None:
        """Finish the queued tasks, but wait no longer than ``timeout`` [wall s].

        A second call has no effect.
        """
        self._tasks.put(None)
        self._thread.join(timeout)

    def _run(self) -> None:
        while (task := self._tasks.get()) is not None:
            try:
                task()
            except Exception:
                logger.exception("a task of the ROS node failed")


@final
class RosoutHandler(logging.Handler):
    """Forwards warnings and errors to rospy, which publishes them on /rosout.

    In a program without logging handlers, warnings and errors are also written to
    standard error.
    """

    def emit(self, record: logging.LogRecord) -> None:
        """Publish the record, and print it if the program has no logging handler."""
        log = rospy.logerr if record.levelno >= logging.ERROR else rospy.logwarn
        if not rospy.is_shutdown():
            log("%s", record.getMessage())
        if not logging.getLogger().handlers and logging.lastResort is not None:
            logging.lastResort.handle(record)


@final
class RosNode:
    """The ROS node of the process. rospy does not allow a second node."""

    def __init__(self, options: Ros1Options, master: Master) -> None:
        """Register with the master.

        Raises:
            RosUnavailableError: If the name is taken, or if the process already has a
                node.
        """
        if core.is_initialized() or core.is_shutdown():
            raise RosUnavailableError(
                "this process is or was a ROS node, and rospy allows one in a process: "
                "bring the robot up in a process of its own"
            )
        if master.uri_of(options.node) is not None:
            raise RosUnavailableError(
                f"a node {options.node} runs already under {master.uri}; end it, "
                "or give this robot a namespace with --ns"
            )
        self.options = options
        self.master = master
        other_clocks = self.other_clock_publishers()
        _init_node(options.root)
        self.clock = RosClock(publish=not other_clocks)
        self._last_error = ("", -_REPEAT_PERIOD)
        self._results = WorkerThread("tool0 ros1 results")
        self.submit = self._results.submit
        self._rosout = RosoutHandler(logging.WARNING)
        logging.getLogger("tool0").addHandler(self._rosout)

    @property
    def uri(self) -> str:
        """Address at which the master and other nodes can reach this node."""
        return str(core.get_node_uri())

    def log_error(self, text: str) -> None:
        """Log an error, also on /rosout.

        A repeated error is logged at most once a second.
        """
        last, when = self._last_error
        now = time.monotonic()
        if text != last or now - when >= _REPEAT_PERIOD:
            self._last_error = (text, now)
            logger.error("%s", text)

    def other_clock_publishers(self) -> tuple[str, ...]:
        """Return the other nodes that publish /clock and are alive."""
        return tuple(
            name
            for name in self.master.publishers_of("/clock")
            if name != self.options.node and self.master.uri_of(name)
        )

    def arbitrate_clock(self) -> None:
        """Publish /clock if no other node publishes it.

        If another node also publishes /clock, the node with the later name in
        alphabetical order stops publishing /clock.
        """
        others = self.other_clock_publishers()
        if not self.clock.is_publisher and not others:
            self.clock.start_publishing()
            logger.warning("publishing /clock now: no other node does")
        elif self.clock.is_publisher and any(n < self.options.node for n in others):
            self.clock.follow_other()
            logger.warning("%s publishes /clock, too: following it now", min(others))

    def register_again(self) -> None:
        """Register all topics and services with a master that lacks this node."""
        topics, services = get_topic_manager(), get_service_manager()
        for topic, kind in topics.get_publications():
            self.master.call("registerPublisher", topic, kind, self.uri)
        for service, address in services.get_services():
            self.master.call("registerService", service, address, self.uri)
        for topic, kind in topics.get_subscriptions():
            found = self.master.call("registerSubscriber", topic, kind, self.uri)
            # the same call that a master makes
            with ServerProxy(self.uri) as ourselves:
                ourselves.publisherUpdate("/master", topic, found)

    def close(self) -> None:
        """Unregister the node.  This process cannot start another node."""
        logging.getLogger("tool0").removeHandler(self._rosout)
        self._results.close()
        uri = self.uri
        rospy.signal_shutdown("the bring-up ended")
        with contextlib.suppress(RosUnavailableError):
            # The call also removes names that a rospy thread registers in the meantime.
            self.master.unregister_all(uri)


def _init_node(root: str) -> None:
    # The call has the same effect as ROS_NAMESPACE, which rospy reads only when it is
    # imported.
    names._set_caller_id(f"{root}/unnamed")
    before = os.environ.get("ROS_PYTHON_LOG_CONFIG_FILE")
    own = resources.files("tool0.ros1") / "logging.yaml"
    with resources.as_file(own) as file:
        os.environ["ROS_PYTHON_LOG_CONFIG_FILE"] = before or str(file)
        try:
            rospy.init_node(
                NODE_NAME, argv=[], disable_signals=True, disable_rostime=True
            )
        finally:
            if before is None:
                del os.environ["ROS_PYTHON_LOG_CONFIG_FILE"]
