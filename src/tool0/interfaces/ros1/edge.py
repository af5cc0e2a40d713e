"""The ROS 1 edge of a running robot, put together."""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable
from types import TracebackType
from typing import final

from tool0.api.robot import Robot
from tool0.errors import RosUnavailableError
from tool0.installation.ros1.library import keep_to_this_machine
from tool0.installation.ros1.master import Master, MasterWatch, running_master
from tool0.installation.ros1.messages import import_messages
from tool0.interfaces.ros1.camera_edge import CameraEdges
from tool0.interfaces.ros1.controllers import ControllerEdges
from tool0.interfaces.ros1.force_torque_edge import force_torque_edges
from tool0.interfaces.ros1.gazebo.services import present_gazebo
from tool0.interfaces.ros1.manager_services import ManagerServices
from tool0.interfaces.ros1.node import Part, RosNode
from tool0.interfaces.ros1.options import Ros1Options
from tool0.interfaces.ros1.parameters import upload
from tool0.interfaces.ros1.rosout import forward_to_rosout
from tool0.interfaces.ros1.transforms import transforms_of
from tool0.runtime.bus import WasReset
from tool0.sensing.snapshot import Snapshot

logger = logging.getLogger(__name__)

_WATCH_PERIOD = 1.0  # [s] between looks at the master
_PATIENCE = 0.2  # [s] for a snapshot, before we look whether it is over


@final
class Ros1:
    """What ros_control and gazebo_ros present, over one robot.  A context manager.

    rospy allows one node in a process, and none after it: so does this.
    """

    def __init__(
        self,
        robot: Robot,
        options: Ros1Options | None = None,
        *,
        when_killed: Callable[[], None] = lambda: None,
    ) -> None:
        """Register with the master and present the robot.

        Args:
            robot: The robot.  It is the caller's to close, after this.
            options: The namespace and the like.
            when_killed: Called, by a thread of rospy's, when somebody ends the node:
                ``rosnode kill``, or another node of the same name.

        Raises:
            RosUnavailableError: If there is no ROS or no master, or the name is taken.
        """
        options = options or Ros1Options()
        keep_to_this_machine()
        import_messages()
        self._robot = robot
        self._over = threading.Event()
        with contextlib.ExitStack() as exits:
            master = Master(options.node)
            exits.enter_context(running_master(master, start=options.roscore))
            self.node = node = RosNode(options, master, robot.description.tf_prefix)
            exits.callback(node.close)
            handler = forward_to_rosout()
            exits.callback(logging.getLogger("tool0").removeHandler, handler)
            upload(node, robot)
            controllers = ControllerEdges(node, robot)
            self._parts: list[Part] = [controllers]
            ManagerServices(node, robot, controllers)
            node.time.advance(robot.snapshot.time)
            self._parts.append(present_gazebo(node, robot))
            self._parts += force_torque_edges(node, robot)
            self._parts.append(CameraEdges(node, robot))
            self._transforms = transforms_of(node, robot)
            self._parts.append(self._transforms)
            for part in self._parts:
                exits.callback(part.close)
            self._threads = [
                threading.Thread(target=target, name=name, daemon=True)
                for target, name in (
                    (self._relay, "tool0 ros1 publisher"),
                    (self._watch, "tool0 ros1 watch"),
                )
            ]
            self._exits = exits.pop_all()
        for thread in self._threads:
            thread.start()
        _call_when_killed(self._over, when_killed)

    def close(self) -> None:
        """Unregister, and end what was started; closing twice is allowed."""
        self._over.set()
        for thread in self._threads:
            thread.join()
        self._exits.close()

    def __enter__(self) -> Ros1:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _relay(self) -> None:
        """Hand every snapshot to every part."""
        subscription = self._robot.subscribe()
        try:
            while not self._over.is_set():
                snapshot = subscription.following(_PATIENCE)
                while subscription.events:
                    if isinstance(subscription.events.popleft(), WasReset):
                        self._restart()
                if snapshot is not None:
                    self._publish(snapshot)
        finally:
            subscription.close()

    def _publish(self, snapshot: Snapshot) -> None:
        self.node.time.advance(snapshot.time)
        for part in self._parts:
            try:
                part.publish(snapshot)
            except Exception as error:  # one part's trouble is not the others'
                self.node.complain(f"{type(part).__name__}: {error}")

    def _restart(self) -> None:
        for part in self._parts:
            part.restart()

    def _watch(self) -> None:
        """See that the master knows us, and that somebody publishes /clock."""
        node = self.node

        def again() -> None:
            upload(node, self._robot)
            node.register_again()
            self._transforms.register_again()

        watch = MasterWatch(node.master, node.options.node, node.uri, again)
        while not self._over.wait(_WATCH_PERIOD):
            try:
                watch.check()
                self._agree_on_the_clock()
            except RosUnavailableError as error:
                node.complain(str(error))

    def _agree_on_the_clock(self) -> None:
        """Take /clock over if nobody publishes it; of two who do, one gives up."""
        time, own = self.node.time, self.node.options.node
        others = self.node.clocks_of_others()
        if not time.is_ours and not others:
            time.take_over()
            logger.warning("the other robot is gone: /clock is ours now")
        elif time.is_ours and any(other < own for other in others):
            time.give_up()
            logger.warning("%s publishes /clock, too: we follow it now", min(others))


def _call_when_killed(over: threading.Event, when_killed: Callable[[], None]) -> None:
    from rospy import on_shutdown

    def tell() -> None:
        if not over.is_set():
            logger.warning("the ROS node was ended from outside")
            when_killed()

    on_shutdown(tell)
