"""The ROS 1 interface of a running robot.

This module and ``options`` do not need ROS.  The modules that are imported inside
functions need ROS.
"""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, final

from tool0.api.robot import Robot
from tool0.description.packages import BUNDLED
from tool0.errors import RosUnavailableError
from tool0.installation.ros1.library import keep_to_this_machine
from tool0.installation.ros1.master import Master, MasterWatch, running_master
from tool0.installation.ros1.messages import import_messages
from tool0.ros1.options import Ros1Options

if TYPE_CHECKING:
    from tool0.ros1.node import SnapshotPublisher

logger = logging.getLogger(__name__)

_MASTER_PERIOD = 1.0
"""Interval between two checks of the master [wall s]."""
_SNAPSHOT_TIMEOUT = 0.2
"""Longest wait for a snapshot before the thread checks whether it must end [wall s]."""


@final
class Ros1Bridge(contextlib.AbstractContextManager["Ros1Bridge"]):
    """Context manager that presents one robot as ros_control and gazebo_ros do.

    A process can have only one bridge in its lifetime, because rospy allows only one
    node in a process.
    """

    def __init__(
        self,
        robot: Robot,
        options: Ros1Options | None = None,
        *,
        on_shutdown: Callable[[], None] = lambda: None,
    ) -> None:
        """Register with the master and present the robot.

        Args:
            robot: The robot, which runs in this process.  The caller must close the
                robot after the bridge.
            options: The namespace and rates.
            on_shutdown: Function that a rospy thread calls when the node is shut down
                from outside, by ``rosnode kill`` or by another node of the same name.

        Raises:
            RosUnavailableError: If there is no ROS or no master, or if the node's name
                is taken.
        """
        options = options or Ros1Options()
        keep_to_this_machine()
        import_messages()
        # The following modules import ROS, which import_messages has found.
        import rospy

        from tool0.ros1.controller_manager import ControllerManagerBridge
        from tool0.ros1.gazebo.services import offer_gazebo_services
        from tool0.ros1.namespace import namespaces_of
        from tool0.ros1.node import RosNode, WorkerThread
        from tool0.ros1.publishers import (
            RobotStatePublisher,
            StaticFrames,
            fixed_frames,
            sensor_publishers,
        )

        self._robot = robot
        self._on_shutdown = on_shutdown
        self._is_closing = threading.Event()
        with contextlib.ExitStack() as stack:
            master = Master(options.node)
            stack.enter_context(running_master(master, start=options.roscore))
            self.node = node = RosNode(options, master)
            stack.callback(node.close)
            namespaces = namespaces_of(node, robot)
            defined = robot.info.defined_controllers
            self._managed = [ros for ros in namespaces if ros.has_controllers(defined)]
            self._upload_parameters()
            managers = [ControllerManagerBridge(ros, robot) for ros in self._managed]
            # The clock must be advanced after the action servers are created, because
            # the action servers stop actionlib's timers.  actionlib's timers fail if
            # time moves back, which may happen before another robot's clock is known.
            node.clock.advance(robot.snapshot.time)
            root = namespaces[0]
            static = StaticFrames(root)
            stack.callback(static.close)
            for ros in namespaces:
                static.add(fixed_frames(ros, robot))
            self._transforms = [
                RobotStatePublisher(ros, robot, static)
                for ros in namespaces
                if ros.has_robot
            ]
            renderer = WorkerThread("tool0 ros1 cameras")  # one thread for all cameras
            self._publishers: list[SnapshotPublisher] = [
                *managers,
                offer_gazebo_services(root, robot),
                *(
                    publisher
                    for ros in namespaces
                    for publisher in sensor_publishers(ros, robot, renderer)
                ),
                *self._transforms,
            ]
            for publisher in self._publishers:
                stack.callback(publisher.close)
            self._stack = stack.pop_all()
        self._threads = [
            threading.Thread(target=target, name=name, daemon=True)
            for target, name in (
                (self._publish_all, "tool0 ros1 publisher"),
                (self._watch_master, "tool0 ros1 watch"),
            )
        ]
        for thread in self._threads:
            thread.start()
        rospy.on_shutdown(self._handle_shutdown)

    def close(self) -> None:
        """Unregister, and stop all threads.  A second call has no effect."""
        self._is_closing.set()
        for thread in self._threads:
            thread.join()
        self._stack.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _publish_all(self) -> None:
        """Pass every snapshot to every publisher."""
        with contextlib.closing(self._robot.subscribe()) as subscription:
            while not self._is_closing.is_set():
                snapshot = subscription.following(_SNAPSHOT_TIMEOUT)
                if snapshot is None:
                    continue
                self.node.clock.advance(snapshot.time)
                for publisher in self._publishers:
                    try:
                        publisher.publish(snapshot)
                    except Exception as error:
                        # an error must not stop the other publishers
                        self.node.log_error(f"{type(publisher).__name__}: {error}")

    def _watch_master(self) -> None:
        """Check that the master has this node, and that one node publishes /clock."""
        node = self.node

        def register() -> None:
            self._upload_parameters()
            node.register_again()
            for transforms in self._transforms:
                transforms.register_again()

        watch = MasterWatch(node.master, node.options.node, node.uri, register)
        while not self._is_closing.wait(_MASTER_PERIOD):
            try:
                watch.check()
                node.arbitrate_clock()
            except RosUnavailableError as error:
                node.log_error(str(error))

    def _upload_parameters(self) -> None:
        """Set use_sim_time, robot_description and the controllers' parameters."""
        call = self.node.master.call
        call("setParam", "/use_sim_time", True)
        for ros in self._managed:
            if ros.urdf is not None:
                urdf = with_mesh_files(ros.urdf)
                call("setParam", ros.name("robot_description"), urdf)
            for name, value in ros.own_parameters(self._robot.info.parameters).items():
                if (converted := _to_xmlrpc(value)) is not None:
                    call("setParam", ros.name(name), converted)

    def _handle_shutdown(self) -> None:
        if not self._is_closing.is_set():
            logger.warning("the ROS node was ended from outside")
            self._on_shutdown()


def with_mesh_files(urdf: str) -> str:
    """Return the URDF with ``file://`` URIs for the meshes that tool0 contains.

    ROS does not find the packages inside tool0.  With ``package://`` URIs, RViz would
    show no robot unless tool0's packages were in ``ROS_PACKAGE_PATH``.  Other
    ``package://`` URIs do not change.
    """
    for folder in BUNDLED.iterdir():
        if (folder / "package.xml").is_file():
            urdf = urdf.replace(f"package://{folder.name}/", f"{folder.as_uri()}/")
    return urdf


def _to_xmlrpc(value: object) -> object:
    """Return ``value`` for XML-RPC, which has no nulls and no integers over 32 bits."""
    match value:
        case dict():
            items = ((str(name), _to_xmlrpc(item)) for name, item in value.items())
            return {name: item for name, item in items if item is not None}
        case list():
            return [item for item in map(_to_xmlrpc, value) if item is not None]
        case bool():
            return value
        case int() if not -(2**31) <= value < 2**31:
            return float(value)
    return value
