"""The complete node of a bring-up, with all parts that it presents."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any, Final

from rcl_interfaces.msg import Log
from rclpy.executors import (
    ExternalShutdownException,
    ShutdownException,
    SingleThreadedExecutor,
)
from rclpy.node import Node
from rclpy.qos import qos_profile_rosout_default

from tool0_ros2 import requests
from tool0_ros2.bridge import Context, Part, Reporter, Update
from tool0_ros2.clock import Clock
from tool0_ros2.connection import Connection, RequestFailedError, failure
from tool0_ros2.controllers import Controllers
from tool0_ros2.manager import ControllerManager, manager_node
from tool0_ros2.names import Names
from tool0_ros2.quiet import only_log_lines
from tool0_ros2.registry import ROBOT, SIMULATION, part_class
from tool0_ros2.requests import (
    ControlBoxState,
    DescriptionInfo,
    LogMessage,
    Message,
    SimulationInfo,
    StateMessage,
)
from tool0_ros2.robot import RobotPart

NODE_NAME = "tool0"
MAX_RATE = 500.0
"""Largest rate of updates [Hz]."""
_FIELDS: Final = (
    *("joint_names", "position", "velocity", "effort", "controllers", "control_boxes"),
)
"""Fields that every update contains."""
_MOTION_FIELDS: Final = ("motions", "command")
_REFRESH_PERIOD = 0.5
"""Interval between two checks for changes in the parts' ``wants`` [wall s]."""
_WATCH_PERIOD = 1.0
"""Interval between two checks of other nodes [wall s]."""
_FOLLOW_TIMEOUT = 10.0
"""Longest wait for the node of a controller [wall s]."""


class _Worker:
    """An executor in a separate thread.

    An error in a callback does not end the thread.
    """

    def __init__(self, ros: Any, name: str) -> None:
        self.executor = SingleThreadedExecutor(context=ros)
        self._is_closing = False
        self._thread = threading.Thread(target=self._spin, name=name, daemon=True)
        self._log: Any = None

    def start(self, logger: Any) -> None:
        self._log = logger
        self._thread.start()

    def submit(self, task: Callable[[], object]) -> None:
        """Schedule a call of ``task`` in the thread."""
        self.executor.create_task(task)

    def close(self) -> None:
        """End the thread.  No task may be submitted after this call."""
        self._is_closing = True
        self.executor.shutdown(timeout_sec=0.0)
        if self._thread.is_alive():
            self._thread.join(_FOLLOW_TIMEOUT)

    def _spin(self) -> None:
        while not self._is_closing:
            try:
                self.executor.spin_once()
            except (ExternalShutdownException, ShutdownException):
                return
            except Exception as error:
                if not self._is_closing:
                    self._log.error(f"a callback failed: {error!r}")


class _Namespace:
    """Contents of one namespace: the whole robot, or one robot of a cell."""

    def __init__(
        self,
        context: Context,
        urdf: str,
        executor: Any,
        *,
        update_rate: float,
        tf_rate: float,
        follow: Callable[[], None],
    ) -> None:
        self.robot = RobotPart(context, urdf, tf_rate)
        self.controllers = Controllers(context, executor)
        self.manager_node = manager_node(context, update_rate, urdf)
        context = Context(
            **{
                **vars(context),
                "node": self.manager_node,
                "report": Reporter(self.manager_node.get_logger()),
            }
        )
        self.manager = ControllerManager(context, follow)
        self.others: list[Part] = []

    @property
    def parts(self) -> list[Part]:
        return [self.robot, *self.others, *self.controllers.parts]

    def update(self) -> None:
        """Follow the controllers of the simulation."""
        statuses = self.controllers.update()
        is_on = self.controllers.has_active_broadcaster(statuses)
        self.robot.has_joint_states = is_on
        self.manager.publish_activity(statuses)


class RobotNode:
    """Presents the robot of a bring-up in ROS 2, from ``start`` to ``close``."""

    def __init__(self, ros: Any, namespace: str) -> None:
        """Create the main node in ``namespace``.  ``ros`` is an rclpy.Context."""
        self._root = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
        self.node = Node(
            NODE_NAME,
            namespace=self._root or "/",
            context=ros,
            use_global_arguments=False,
        )
        self.has_ended = threading.Event()
        """Event that is set when the bring-up has ended."""
        self._control = _Worker(ros, "controllers")
        self._services = _Worker(ros, "services")
        self._clock = Clock(self.node)
        self._report = Reporter(self.node.get_logger())
        self._rosout = self.node.create_publisher(
            Log, "/rosout", qos_profile_rosout_default
        )
        self._connection: Connection | None = None
        self._namespaces: list[_Namespace] = []
        self._nodes = [self.node]
        self._parts: list[Part] = []
        self._index: dict[str, int] = {}
        self._control_boxes: list[ControlBoxState] = []
        self._wanted: list[str] | None = None
        self._has_updates = threading.Event()

    def start(self, connection: Connection, options: Any) -> None:
        """Present the robot, and return when all parts are ready.

        Args:
            connection: A connection on which ``start`` has not been called yet.
            options: Command-line options, such as ``tf_rate``.
        """
        self._connection = connection
        connection.on_message = self._take
        connection.on_end = self._end
        connection.start()
        description = connection.call(requests.read_description())
        info = connection.call(requests.read_info())
        self._rate = rate = min(MAX_RATE, 1.0 / info["control_period"])
        for names, urdf in _namespaces(self._root, description):
            context = self._context(connection, names, description, info, options)
            with only_log_lines():
                space = _Namespace(
                    context,
                    urdf,
                    self._control.executor,
                    update_rate=rate,
                    tf_rate=options.tf_rate,
                    follow=self._follow,
                )
                self._namespaces.append(space)
                space.others += self._made(ROBOT, context)
            space.update()
            self._nodes.append(space.manager_node)
            self._services.executor.add_node(space.manager_node)
        context = self._context(
            connection, Names(self._root), description, info, options
        )
        self._parts = self._made(SIMULATION, context)
        self._control.executor.add_node(self.node)
        self.node.create_timer(_REFRESH_PERIOD, self._refresh)
        self.node.create_timer(_WATCH_PERIOD, self._watch)
        for worker in (self._control, self._services):
            worker.start(self.node.get_logger())
        self._refresh()
        self._has_updates.wait(_FOLLOW_TIMEOUT)

    def close(self) -> None:
        """End the connection, the threads and the nodes."""
        self.has_ended.set()
        if self._connection is not None:
            self._connection.close()
        self._services.close()
        self._control.close()
        for part in self._parts:
            part.close()
        for space in self._namespaces:
            space.controllers.close()
            for part in (*space.others, space.robot):
                part.close()
        for node in self._nodes:
            node.destroy_node()

    def _made(self, entries: list[str], context: Context) -> list[Part]:
        """Return the parts whose message packages are installed."""
        found = []
        for entry in entries:
            try:
                found.append(part_class(entry)(context))
            except ImportError as error:
                self._report.error(f"{entry}: {error}")
        return found

    def _context(
        self,
        connection: Connection,
        names: Names,
        description: DescriptionInfo,
        info: SimulationInfo,
        options: Any,
    ) -> Context:
        return Context(
            connection=connection,
            names=names,
            clock=self._clock,
            node=self.node,
            report=self._report,
            refresh=partial(self._control.submit, self._refresh),
            new_node=partial(self._new_node, names),
            description=description,
            info=info,
            options=options,
        )

    def _new_node(self, names: Names, name: str) -> Any:
        node = Node(
            name,
            namespace=names.root or "/",
            context=self.node.context,
            use_global_arguments=False,
        )
        self._nodes.append(node)
        self._services.executor.add_node(node)
        return node

    # ---- in the reader's thread -----------------------------------------------------

    def _take(self, message: Message) -> None:
        if message["type"] == "state":
            self._publish(message)
        elif message["type"] == "fault":
            self._report.error(f"the simulation has stopped: {message['message']}")
        elif message["type"] == "log":
            self._log(message)
        elif message["type"] == "reply" and "error" in message:
            self._report.error(Names(self._root).text(failure(message["error"])))

    def _log(self, message: LogMessage) -> None:
        """Publish a line of the simulation's log.

        The simulation has already printed the line.
        """
        level = Log.ERROR if message["level"] == "error" else Log.WARN
        stamp = self.node.get_clock().now().to_msg()
        name, text = NODE_NAME, Names(self._root).text(message["message"])
        for space in self._namespaces:
            begin, found, rest = text.partition(": ")
            if found and begin in space.controllers.loaded:
                name, text = space.controllers.names.to_ros(begin), rest
        self._rosout.publish(Log(stamp=stamp, level=level, name=name, msg=text))

    def _publish(self, message: StateMessage) -> None:
        names = message.get("joint_names")
        if names is not None:
            self._index = {name: k for k, name in enumerate(names)}
        if "controllers" in message:
            self._control.submit(self._update)
        self._has_updates.set()
        self._control_boxes = message.get("control_boxes", self._control_boxes)
        stamp = self._clock.advance(message["time"])
        update = Update(message, self._index, stamp, self._control_boxes)
        for space in self._namespaces:
            space.controllers.publish(update)
            for part in (space.robot, *space.others):
                try:
                    part.publish(update)
                except Exception as error:  # an error must not stop the other parts
                    self._report.error(f"{type(part).__name__}: {error!r}")

    def _end(self, reason: str) -> None:
        self.node.get_logger().info(f"{reason}: the node ends")
        self.has_ended.set()

    # ---- in the executor's thread ---------------------------------------------------

    def _update(self) -> None:
        """Follow the controllers of the simulation."""
        try:
            for space in self._namespaces:
                space.update()
        except RequestFailedError as error:
            if not self.has_ended.is_set():
                self._report.error(f"cannot follow the controllers: {error}")

    def _follow(self) -> None:
        """Follow the controllers immediately.

        The method must not be called in the executor's thread.
        """
        done = threading.Event()

        def update() -> None:
            self._update()
            done.set()

        self._control.submit(update)
        done.wait(_FOLLOW_TIMEOUT)

    def _refresh(self) -> None:
        """Subscribe to the fields that the parts need."""
        wanted = [
            name
            for space in self._namespaces
            for part in space.parts
            for name in part.wants()
        ]
        connection = self._connection
        if connection is None or wanted == self._wanted:
            return
        self._wanted = wanted
        future = connection.submit(
            requests.subscribe(
                rate=self._rate,
                fields=(*_FIELDS, *_MOTION_FIELDS) if wanted else _FIELDS,
                controllers=wanted,
                newest_only=True,
            )
        )
        future.add_done_callback(self._report_refusal)

    def _report_refusal(self, future: Any) -> None:
        error = future.exception()
        if error is not None and not self.has_ended.is_set():
            self._report.error(str(error))

    def _watch(self) -> None:
        self._clock.arbitrate()
        for space in self._namespaces:
            space.robot.look_for_publisher()
            space.robot.look_for_twin()


def _namespaces(root: str, description: DescriptionInfo) -> list[tuple[Names, str]]:
    """Return the names and the URDF of each namespace."""
    cell = description["namespaces"]
    if not cell:
        return [(Names(root), _with_mesh_files(description["urdf"], description))]
    prefixes = [f"{item['name']}_" for item in cell]
    return [
        (
            Names(
                f"{root}/{item['name']}",
                prefix,
                tf_prefix=item["name"],
                longer=[p for p in prefixes if p != prefix and p.startswith(prefix)],
            ),
            _with_mesh_files(item["urdf"], description),
        )
        for item, prefix in zip(cell, prefixes)
    ]


def _with_mesh_files(urdf: str, description: DescriptionInfo) -> str:
    """Return the URDF with ``file://`` URIs for the meshes that tool0 contains.

    ROS does not find the packages inside tool0.  With ``package://`` URIs, RViz would
    show no robot.
    """
    for package, uri in description["packages"].items():
        urdf = urdf.replace(f"package://{package}/", f"{uri}/")
    return urdf
