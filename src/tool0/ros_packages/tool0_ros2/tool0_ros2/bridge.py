"""What all parts of the node share: their context and the updates."""

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
    """The robot's state at one control update; lists are in the order of the joints."""

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
        """Full name of each movable joint → index in the lists."""
        self.position: list[float] = message["position"]
        """Measured positions [rad | m]."""
        self.velocity: list[float] = message["velocity"]
        """Measured velocities [rad/s | m/s]."""
        self.effort: list[float] = message["effort"]
        """Applied efforts [N·m | N]."""
        self.command: list[float] = message.get("command", [])
        """The last commands if a part of the node wants a motion, otherwise empty."""
        self.motions: dict[str, ControllerMotion] = message.get("motions", {})
        """Motion of each requested controller, by its full name."""
        self.control_boxes = control_boxes
        """The control box of each arm; the list object stays the same until a box
        changes."""


class Part(Protocol):
    """Presents a part of the robot, such as one controller, in ROS.

    A part is created and closed in the executor's thread.  The reader's thread calls
    ``publish`` at every update while the part's controller is active, or always if the
    part belongs to no controller.  Without subscribers, a call should cost little.
    """

    def wants(self) -> Sequence[str]:
        """Return the controllers whose motion the part now needs in updates."""

    def publish(self, update: Update) -> None:
        """Publish the messages that are due; time may have gone back to zero."""

    def close(self) -> None:
        """Destroy publishers, services …; the controller's node is destroyed later."""


class Rate:
    """Determines when events are due, in simulated time or wall time."""

    def __init__(self, rate: float) -> None:
        """Set the rate of events [Hz]; 0 for none."""
        self._period = 1.0 / rate if rate > 0.0 else None
        self._last = float("-inf")

    def is_due(self, now: float) -> bool:
        """Return whether an event is due at ``now`` [s]; if so, mark it as done."""
        period, elapsed = self._period, now - self._last
        if period is None or 0.0 <= elapsed < period - 1e-6:
            return False
        # Stay on multiples of the period, so that the mean rate is right even if the
        # rate of updates is not a multiple of it.
        is_regular = 0.0 <= elapsed < 2.0 * period
        self._last = self._last + period if is_regular else now
        return True


class Reporter:
    """Logs on /rosout: repeated errors at most once a second, each warning once."""

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
    """Connection for requests to the simulation."""
    names: Names
    """The namespace in ROS, and the names of joints and frames in it."""
    clock: Clock
    """Converter between simulated time and ROS time."""
    node: Any
    """The rclpy.Node: the controller's own node, or else the main node."""
    report: Reporter
    """The node's log."""
    refresh: Callable[[], None]
    """Function to call when a part's ``wants`` have changed; otherwise the change is
    noticed within half a second."""
    new_node: Callable[[str], Any]
    """Returns another rclpy.Node of this name in the namespace, for services that may
    take long; its callbacks run in a separate thread."""
    description: DescriptionInfo
    """The response to ``read_description``."""
    info: SimulationInfo
    """The response to ``read_info``."""
    options: Any
    """Command-line options: ``tf_rate``, ``camera_rate`` [Hz], …"""

    def ask(self, request: Request[T], use: str) -> T | None:
        """Return the response to a request; None if the robot does not offer it.

        As not every robot offers every request, a warning then says that ``use`` is
        left out.
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
    """Parameters, including defaults: dotted name → value, with full names of joints.

    Values change when somebody sets a parameter.
    """
    status: ControllerStatus
    """The controller's entry in ``list_controllers`` when the part was created."""
