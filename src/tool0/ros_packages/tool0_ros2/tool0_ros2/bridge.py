"""Shared by the parts of the node: their context, and the updates."""

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
    """The state of the robot at one control update, in the order of the joints."""

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
        """Simulated [s]."""
        self.tick: int = message["tick"]
        self.stamp = stamp
        """The same as a builtin_interfaces/Time."""
        self.index = index
        """Position of each movable joint, by its full name, in the lists."""
        self.position: list[float] = message["position"]
        """Measured positions [rad | m]."""
        self.velocity: list[float] = message["velocity"]
        """Measured velocities [rad/s | m/s]."""
        self.effort: list[float] = message["effort"]
        """Applied efforts [N·m | N]."""
        self.command: list[float] = message.get("command", [])
        """The last commands, if a part of the node wants a motion."""
        self.motions: dict[str, ControllerMotion] = message.get("motions", {})
        """Motion of each controller that was asked for, by its full name."""
        self.control_boxes = control_boxes
        """The control box of each arm: the same list until one changes."""


class Part(Protocol):
    """Presents a part of the robot, such as one controller, in ROS.

    It is made and closed in the executor's thread.  The reader's thread calls
    ``publish`` at every update while its controller is active; a part of no controller
    is always called.  Without subscribers it should cost little.
    """

    def wants(self) -> Sequence[str]:
        """Return the controllers whose motion it needs in the updates now."""

    def publish(self, update: Update) -> None:
        """Publish the messages that are due.  Time may have gone back to zero."""

    def close(self) -> None:
        """Destroy publishers, services …; the node of a controller ends afterwards."""


class Rate:
    """Says when something is due in simulated time, or in wall time."""

    def __init__(self, rate: float) -> None:
        """Set the rate of events [Hz]; 0 for none."""
        self._period = 1.0 / rate if rate > 0.0 else None
        self._last = float("-inf")

    def is_due(self, now: float) -> bool:
        """Return whether one is due ``now`` [s], and count it then."""
        period, elapsed = self._period, now - self._last
        if period is None or 0.0 <= elapsed < period - 1e-6:
            return False
        # Multiples of the period: so does a rate hold that the updates' is no multiple
        # of.
        is_regular = 0.0 <= elapsed < 2.0 * period
        self._last = self._last + period if is_regular else now
        return True


class Reporter:
    """Logs on /rosout: the same error at most once a second, a warning once."""

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
    """Requests to the simulation."""
    names: Names
    """The namespace in ROS, and the names of joints and frames in it."""
    clock: Clock
    """Simulated time ↔ ROS time."""
    node: Any
    """The rclpy.Node: the controller's own one, or the main one."""
    report: Reporter
    """The node's log."""
    refresh: Callable[[], None]
    """Call this when the ``wants`` of a part have changed; other parts notice it within
    half a second."""
    new_node: Callable[[str], Any]
    """Returns another rclpy.Node of this name in the namespace, for services that may
    take long: its callbacks run in a thread of their own."""
    description: DescriptionInfo
    """The response to ``read_description``."""
    info: SimulationInfo
    """The response to ``read_info``."""
    options: Any
    """Options of the command line: ``tf_rate``, ``camera_rate`` [Hz], …"""

    def ask(self, request: Request[T], use: str) -> T | None:
        """Return the response to a request, or None where the robot has no answer.

        Not every robot offers every request: a warning says that ``use`` is left out.
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
    """Context of the part of a controller."""

    name: str
    """The full name of the controller: that in requests."""
    type: str
    parameters: dict[str, Any]
    """Dotted name → value, with defaults, by full names of joints.

    They change when somebody sets one.
    """
    status: ControllerStatus
    """Entry of the controller in ``list_controllers`` when it was loaded."""
