"""The wrench at the wrist in ROS, by the names of Universal Robots' own driver."""

from __future__ import annotations

from typing import Any, final

from tool0.api.robot import Robot
from tool0.api.sensors import ForceTorque
from tool0.errors import ControlError
from tool0.interfaces.ros1.conversions import Message
from tool0.interfaces.ros1.node import RosNode
from tool0.sensing.force_torque import WrenchReading
from tool0.sensing.snapshot import Snapshot

TOPIC = "wrench"
SERVICE = "ur_hardware_interface/zero_ftsensor"


@final
class ForceTorqueEdge:
    """A topic that publishes while somebody listens, and a service that zeroes.

    The sensor starts with the first listener, and goes on: a stop would forget a zero.
    """

    def __init__(self, node: RosNode, sensor: ForceTorque) -> None:
        from geometry_msgs.msg import WrenchStamped
        from std_srvs.srv import Trigger, TriggerResponse

        self._node = node
        self._sensor = sensor
        prefix = node.frame_prefix
        self._frame = f"{prefix}/{sensor.link}" if prefix else sensor.link
        self._message = WrenchStamped
        self._publisher = node.publisher(TOPIC, WrenchStamped, queue_size=100)
        self._answer = TriggerResponse
        self._service = node.service(SERVICE, Trigger, self._zero)
        self._seen: int | None = None

    def publish(self, snapshot: Snapshot) -> None:
        """Publish what was sampled since the last time, filtered, if one listens."""
        if not self._publisher.get_num_connections():
            self._seen = None
            return
        if self._seen is None:
            self._seen = self._sensor.read().number - 1
        for reading in self._sensor.samples(self._seen):
            self._seen = reading.number
            self._publisher.publish(self._stamped(reading))

    def restart(self) -> None:
        """Forget nothing: samples go on counting."""

    def close(self) -> None:
        """Present it no longer."""
        self._service.shutdown()
        self._publisher.unregister()

    def _stamped(self, reading: WrenchReading) -> Message:
        message: Any = self._message(header=self._node.header(reading.time))
        message.header.frame_id = self._frame
        force, torque = message.wrench.force, message.wrench.torque
        force.x, force.y, force.z = reading.force
        torque.x, torque.y, torque.z = reading.torque
        return message

    def _zero(self, request: Message) -> Message:
        self._sensor.zero()
        return self._answer(success=True, message="the wrench is zero from now on")


def force_torque_edges(node: RosNode, robot: Robot) -> list[ForceTorqueEdge]:
    """Return the edge of the robot's one ``tool0``; none if it has none, or several."""
    try:
        sensor = robot.force_torque
    except ControlError:
        return []
    return [ForceTorqueEdge(node, sensor)]
