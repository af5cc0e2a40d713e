"""The interface of the node's parts, their context, and the updates."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from tool0_ros2.clock import Clock
from tool0_ros2.connection import Connection, RequestFailedError
from tool0_ros2.names import Names
from tool0_ros2.requests import (
    ControlBoxState,
    ControllerMotion,
    ControllerStatus,
    DescriptionInfo,
    Request,
    SimulationInfo,
    StateMessage,
)

T = TypeVar("T")
REPEAT_PERIOD = 1.0
"""Interval at which a repeated error is logged again [wall s]."""


class Update:
    """The robot's state at one control update.  Lists are ordered by joint."""

    __slots__ = (
        *("command", "control_boxes", "effort", "index", "motions"),
        *("position", "stamp", "tick", "time", "velocity"),
    )

    def __init__(
        self,
        message: StateMessage,
        index: dict[str, int],
        stamp: Any,
        control_boxes: list[ControlBoxState],
    ) -> None:
        self.time: float = message["time"]
        """Simulated time [s]."""
        self.tick: int = message["tick"]
        self.stamp = stamp
        """ROS time of the update, as a builtin_interfaces/Time."""
        self.index = index
        """Index of each movable joint in the lists, by the joint's full name."""
        self.position: list[float] = message["position"]
        """Measured positions [rad | m]."""
        self.velocity: list[float] = message["velocity"]
        """Measured velocities [rad/s | m/s]."""
        self.effort: list[float] = message["effort"]
        """Applied efforts [N·m | N]."""
        self.command: list[float] = message.get("command", [])
        """The last commands, if a part of the node requests a motion; otherwise
        empty."""
        self.motions: dict[str, ControllerMotion] = message.get("motions", {})
        """Motion of each requested controller, by the controller's full name."""
        self.control_boxes = control_boxes
        """The control box of each arm.  The list is the same object until a box
        changes."""


class Part(Protocol):
    """Presents a part of the robot, such as one controller, in ROS.

    A part is created and closed in the thread of the executor.  The reader's thread
    calls ``publish`` at every update while the part's controller is active.  If the
    part has no controller, ``publish`` is called at every update.  If there are no
    subscribers, the call must be fast.
    """

    def wants(self) -> Sequence[str]:
        """Return the controllers whose motion the part currently needs in updates."""

    def publish(self, update: Update) -> None:
        """Publish the messages that are due.  Time may have been reset to zero."""

    def close(self) -> None:
        """Destroy the publishers, services and so on.  The node is destroyed later."""


class Rate:
    """Determines when periodic events are due, in simulated time or in wall time."""

    def __init__(self, rate: float) -> None:
        """Set the rate of events [Hz].  At a rate of 0, there are no events."""
        self._period = 1.0 / rate if rate > 0.0 else None
        self._last = float("-inf")

    def is_due(self, now: float) -> bool:
        """Return whether an event is due at ``now`` [s].  Mark a due event as done."""
        period, elapsed = self._period, now - self._last
        if period is None or 0.0 <= elapsed < period - 1e-6:
            return False
        # The events remain at multiples of the period.  The mean rate of the events is
        # therefore correct even if the update rate is not a multiple of it.
        is_regular = 0.0 <= elapsed < 2.0 * period
        self._last = self._last + period if is_regular else now
        return True


class Reporter:
    """Logs on /rosout.

    A repeated error is logged once a second, and a warning is logged only once.
    """

    def __init__(self, logger: Any) -> None:
        self._logger = logger
        self._warnings: set[str] = set()
        self._last = ("", float("-inf"))

    def error(self, text: str) -> None:
        last, when = self._last
        now = time.monotonic()
        if text != last or now - when >= REPEAT_PERIOD:
            self._last = (text, now)
            self._logger.error(text)

    def warning(self, text: str) -> None:
        if text not in self._warnings:
            self._warnings.add(text)
            self._logger.warning(text)


@dataclass
class Context:
    """Context of a part of the node."""

    connection: Connection
    """Connection that is used for requests to the simulation."""
    names: Names
    """The namespace in ROS, and the names of joints and frames in this namespace."""
    clock: Clock
    """Converter between simulated time and ROS time."""
    node: Any
    """The rclpy.Node.  A controller has its own node; other parts use the main node."""
    report: Reporter
    """The node's log."""
    refresh: Callable[[], None]
    """Function to call when the ``wants`` of a part have changed.  Without this call,
    the change is detected within half a second."""
    new_node: Callable[[str], Any]
    """Function that returns another rclpy.Node with the given name in the namespace.
    The node is for services that may take a long time, and the node's callbacks run in
    a separate thread."""
    description: DescriptionInfo
    """The response to ``read_description``."""
    info: SimulationInfo
    """The response to ``read_info``."""
    options: Any
    """Command-line options, such as ``tf_rate`` and ``camera_rate`` [Hz]."""

    def ask(self, request: Request[T], use: str) -> T | None:
        """Return the response to a request; None if the robot does not offer it.

        Not every robot offers every request.  If the robot does not offer the request,
        a warning states that ``use`` is not available.
        """
        try:
            return self.connection.call(request)
        except RequestFailedError as error:
            if error.kind != "NotOfferedError":
                raise
            self.report.warning(f"left out: {use}, since {error}")
            return None


@dataclass
class ControllerContext(Context):
    """Context of a controller's part."""

    name: str
    """The full name of the controller, which requests use."""
    type: str
    parameters: dict[str, Any]
    """Parameters, including defaults, by dotted name.  The parameters contain the full
    names of joints.

    The values change when a client sets a parameter.
    """
    status: ControllerStatus
    """The controller's entry in ``list_controllers`` at the time when the part was
    created."""
