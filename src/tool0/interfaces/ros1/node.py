"""The ROS node of a bring-up: its name, its time, its threads, its complaints."""

from __future__ import annotations

import logging
import os
import queue
import threading
import time
from collections.abc import Callable
from importlib import resources
from typing import Any, Protocol, final

from tool0.errors import RosUnavailableError, Tool0Error
from tool0.installation.ros1.master import Master
from tool0.interfaces.ros1.options import NODE_NAME, Ros1Options
from tool0.interfaces.ros1.ros_time import RosTime
from tool0.sensing.snapshot import Snapshot

logger = logging.getLogger(__name__)

_REPEAT = 1.0  # [s] before the same complaint is made again


class Part(Protocol):
    """Something that the node presents.  One thread calls it."""

    def publish(self, snapshot: Snapshot) -> None:
        """Tell what there is to tell of ``snapshot``."""

    def restart(self) -> None:
        """Forget times: simulated time has gone back to zero."""

    def close(self) -> None:
        """Present it no longer."""


@final
class Worker:
    """A thread that calls what it is given, in order."""

    def __init__(self, name: str) -> None:
        self._tasks: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def defer(self, task: Callable[[], None]) -> None:
        """Have ``task`` called soon; never waits."""
        self._tasks.put(task)

    def close(self, patience: float = 1.0) -> None:
        """Finish what was deferred, as far as it goes within ``patience`` [wall s]."""
        self._tasks.put(None)
        self._thread.join(patience)

    def _run(self) -> None:
        while (task := self._tasks.get()) is not None:
            try:
                task()
            except Exception:
                logger.exception("a task of the ROS node failed")


@final
class RosNode:
    """What every part needs of ROS."""

    def __init__(
        self, options: Ros1Options, master: Master, tf_prefix: str = ""
    ) -> None:
        """Register with the master; and that once in a process.

        Raises:
            RosUnavailableError: If the name is taken, or the process is a node already.
        """
        from rospy import core

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
        self.frame_prefix = tf_prefix.strip("/")
        """Prefix of every frame, without slashes around it."""
        self.master = master
        others = self.clocks_of_others()
        _register(options.root)
        self.time = RosTime(is_ours=not others)
        self._complaint = ("", -_REPEAT)
        self._results = Worker("tool0 ros1 results")
        self.defer = self._results.defer

    @property
    def uri(self) -> str:
        """Where other nodes and the master reach us."""
        from rospy import core

        return str(core.get_node_uri())

    def clocks_of_others(self) -> tuple[str, ...]:
        """Return the nodes that live and publish /clock, but for us."""
        return tuple(
            name
            for name in self.master.publishers_of("/clock")
            if name != self.options.node and self.master.uri_of(name)
        )

    def name(self, relative: str) -> str:
        """Return a name in our namespace; one that begins with a slash stays."""
        return relative if relative[:1] == "/" else f"{self.options.root}/{relative}"

    def header(self, time: float) -> Any:
        """Return a std_msgs/Header with simulated ``time`` [s]."""
        from std_msgs.msg import Header

        return Header(stamp=self.time.to_ros(time))

    def publisher(
        self, name: str, kind: Any, *, queue_size: int = 1, latch: bool = False
    ) -> Any:
        """Return a rospy.Publisher; a subscriber that stalls delays nobody else."""
        from rospy import Publisher

        return Publisher(self.name(name), kind, queue_size=queue_size, latch=latch)

    def subscriber(self, name: str, kind: Any, handle: Callable[[Any], None]) -> Any:
        """Return a rospy.Subscriber whose refusals are told and change nothing."""
        from rospy import Subscriber

        full = self.name(name)

        def receive(message: Any) -> None:
            try:
                handle(message)
            except Tool0Error as error:
                self.complain(f"{full}: {error}")

        return Subscriber(full, kind, receive, queue_size=1)

    def service(self, name: str, kind: Any, handle: Callable[[Any], Any]) -> Any:
        """Return a rospy.Service; who asks is told what ``handle`` raises."""
        from rospy import Service, ServiceException

        full = self.name(name)

        def answer(request: Any) -> Any:
            try:
                return handle(request)
            except Tool0Error as error:
                self.complain(f"{full}: {error}")
                raise ServiceException(str(error)) from None

        return Service(full, kind, answer)

    def complain(self, text: str) -> None:
        """Log an error, here and on /rosout, but not ten times a second."""
        last, when = self._complaint
        now = time.monotonic()
        if text != last or now - when >= _REPEAT:
            self._complaint = (text, now)
            logger.error("%s", text)

    def register_again(self) -> None:
        """Tell a master that does not know us of all that we present."""
        from rospy.impl.registration import (
            get_service_manager,
            get_topic_manager,
        )

        topics, services = get_topic_manager(), get_service_manager()
        for topic, kind in topics.get_publications():
            self.master.call("registerPublisher", topic, kind, self.uri)
        for service, address in services.get_services():
            self.master.call("registerService", service, address, self.uri)
        for topic, kind in topics.get_subscriptions():
            found = self.master.call("registerSubscriber", topic, kind, self.uri)
            _connect(self.uri, topic, found, self.master)

    def close(self) -> None:
        """Unregister everything; no second node can follow in this process."""
        from rospy import signal_shutdown

        self._results.close()
        signal_shutdown("the bring-up ended")


def _connect(uri: str, topic: str, publishers: list[str], master: Master) -> None:
    """Have rospy connect to publishers, by the call that a master makes."""
    from xmlrpc.client import ServerProxy

    with ServerProxy(uri) as ourselves:
        ourselves.publisherUpdate("/master", topic, publishers)


def _register(root: str) -> None:
    import rospy
    from rospy import names

    # As ROS_NAMESPACE would, which counts at the import alone.
    names._set_caller_id(f"{root}/unnamed")
    before = os.environ.get("ROS_PYTHON_LOG_CONFIG_FILE")
    own = resources.files("tool0.interfaces.ros1") / "logging.yaml"
    with resources.as_file(own) as file:
        os.environ["ROS_PYTHON_LOG_CONFIG_FILE"] = before or str(file)
        try:
            rospy.init_node(
                NODE_NAME, argv=[], disable_signals=True, disable_rostime=True
            )
        finally:
            if before is None:
                del os.environ["ROS_PYTHON_LOG_CONFIG_FILE"]
