"""The topic of a force-torque sensor broadcaster, either UR's or the standard one."""

import threading
import time
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import WrenchStamped
from rclpy.qos import QoSProfile

from tool0_ros2 import requests
from tool0_ros2.bridge import ControllerContext, Update
from tool0_ros2.connection import (
    Connection,
    RequestFailedError,
)
from tool0_ros2.control_box import flange_of
from tool0_ros2.errors import TransportError
from tool0_ros2.requests import WrenchReading

RATE = 500.0
"""Number of samples per simulated second, if the control rate is high enough [Hz]."""
_WAIT = 0.2
"""Longest wait for a sample in a request, and longest time for which the thread waits
before it checks whether it must end [wall s]."""
_IDLE = 0.5
"""Time without updates after which the controller is considered inactive [wall s]."""


class WrenchPart:
    """Topic with a sensor's samples while there are subscribers.

    A thread with a separate connection reads the samples.  The first subscriber starts
    the sensor.  The sensor continues without subscribers, because stopping it would
    discard the tare.
    """

    def __init__(self, context: ControllerContext) -> None:
        """Offer ``~/ft_data`` as in UR's driver, or ``~/wrench`` as in ROS."""
        self._context = context
        parameters = context.parameters
        self._frame = context.names.frame(
            parameters.get("frame_id") or context.names.to_model("tool0")
        )
        sensor = (
            parameters.get("sensor_name")
            or parameters.get("interface_names.force.x")
            or parameters.get("interface_names.torque.x")
            or context.names.prefix
        )
        self._link = flange_of(context, sensor)
        topic = parameters.get("topic_name") or "wrench"
        self._publisher = context.node.create_publisher(
            WrenchStamped, f"~/{topic}", QoSProfile(depth=10)
        )
        self._is_wanted = threading.Event()
        self._is_closing = threading.Event()
        self._last_update = 0.0
        self._thread = threading.Thread(target=self._run, name="wrench", daemon=True)
        self._thread.start()

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        """Wake the publishing thread while there are updates and subscribers."""
        if self._publisher.get_subscription_count():
            self._last_update = time.monotonic()
            self._is_wanted.set()
        else:
            self._is_wanted.clear()

    def close(self) -> None:
        self._is_closing.set()
        self._is_wanted.set()
        self._thread.join()
        self._context.node.destroy_publisher(self._publisher)

    # ---- the thread -----------------------------------------------------------------

    def _run(self) -> None:
        connection: Connection | None = None
        while not self._is_closing.is_set():
            if not self._is_wanted.wait(_WAIT) or self._is_closing.is_set():
                continue
            try:
                if connection is None:
                    connection = Connection(self._context.connection.name)
                    connection.start()
                self._publish_samples(connection)
            except (TransportError, RequestFailedError) as error:
                self._context.report.error(f"wrench: {error}")
                self._is_closing.wait(_IDLE)
        if connection is not None:
            connection.close()

    def _publish_samples(self, connection: Connection) -> None:
        """Publish samples until they are no longer requested."""
        link = self._link
        if not connection.call(requests.read_force_torque_rate(link=link)):
            _start(connection, link)
        last = connection.call(requests.read_force_torque(link=link))["number"]
        while self._is_wanted.is_set() and not self._is_closing.is_set():
            if time.monotonic() - self._last_update > _IDLE:
                self._is_wanted.clear()
                return
            request = requests.read_force_torque_samples(
                link=link, since=last, timeout=_WAIT
            )
            for sample in connection.call(request):
                last = sample["number"]
                self._publisher.publish(self._message(sample))

    def _message(self, sample: WrenchReading) -> Any:
        message = WrenchStamped()
        message.header.stamp = self._context.clock.to_ros(sample["time"])
        message.header.frame_id = self._frame
        for name, values in (("force", sample["force"]), ("torque", sample["torque"])):
            vector = getattr(message.wrench, name)
            for axis, value in zip("xyz", values):
                setattr(vector, axis, self._corrected(f"{name}.{axis}", value))
        return message

    def _corrected(self, kind: str, value: float) -> float:
        """Apply the standard broadcaster's ``offset`` and ``multiplier`` to a value."""
        parameters = self._context.parameters
        offset = parameters.get(f"offset.{kind}") or 0.0
        factor = parameters.get(f"multiplier.{kind}", 1.0)
        return float((value + offset) * factor)


def _start(connection: Connection, link: str) -> None:
    """Start the sensor at 500 Hz.  If this is impossible, use the default rate."""
    try:
        connection.call(requests.start_force_torque(link=link, rate=RATE))
    except RequestFailedError as error:
        if error.kind != "ControlError":
            raise
        connection.call(requests.start_force_torque(link=link))
