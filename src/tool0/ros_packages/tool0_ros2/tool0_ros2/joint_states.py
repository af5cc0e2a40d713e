"""The topics of a joint_state_broadcaster."""

from array import array
from collections.abc import Sequence
from typing import Any

from control_msgs.msg import DynamicJointState, InterfaceValue
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from tool0_ros2.bridge import ControllerContext, Update

_LISTS = ("position", "velocity", "effort")


class JointStatePart:
    """Topics ``joint_states`` and ``dynamic_joint_states``, sent at every update."""

    def __init__(self, context: ControllerContext) -> None:
        self._context = context
        self._joints: dict[str, list[str]] = {}
        """Interfaces of each joint in the order of the messages, by the joint's full
        name."""
        for interface in context.status.get("state_interfaces", []):
            joint, _, kind = interface.rpartition("/")
            if kind in _LISTS:
                self._joints.setdefault(joint, []).append(kind)
        parameters = context.parameters
        self._joints = {
            joint: self._joints[joint]
            for joint in parameters.get("joints") or self._joints
            if joint in self._joints
        }
        own = list(map(context.names.to_ros, self._joints))
        extra = parameters.get("extra_joints") or []
        self._n_extra = len(extra)
        local = "~/" if parameters.get("use_local_topics") else ""
        prefix = local or context.names.topic("")
        qos = QoSProfile(depth=10)
        node = context.node
        self._states = node.create_publisher(JointState, f"{prefix}joint_states", qos)
        self._dynamic: Any = None
        if parameters.get("publish_dynamic_joint_states", True):
            topic = f"{prefix}dynamic_joint_states"
            self._dynamic = node.create_publisher(DynamicJointState, topic, qos)
        self._message = JointState(name=[*own, *extra])
        self._message.header.frame_id = parameters.get("frame_id", "base_link")
        self._picked: list[int] | None = None

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        picked = self._picked
        if picked is None:
            index = update.index
            picked = self._picked = [index[joint] for joint in self._joints]
        message, more = self._message, [0.0] * self._n_extra
        message.header.stamp = update.stamp
        for name in _LISTS:
            values: list[float] = getattr(update, name)
            setattr(message, name, array("d", [values[k] for k in picked] + more))
        self._states.publish(message)
        if self._dynamic is not None and self._dynamic.get_subscription_count():
            self._dynamic.publish(self._dynamic_state(update, picked))

    def close(self) -> None:
        node = self._context.node
        node.destroy_publisher(self._states)
        if self._dynamic is not None:
            node.destroy_publisher(self._dynamic)

    def _dynamic_state(self, update: Update, picked: list[int]) -> Any:
        message = DynamicJointState(joint_names=self._message.name)
        message.header.stamp = update.stamp
        message.interface_values = [
            InterfaceValue(
                interface_names=kinds,
                values=[getattr(update, kind)[k] for kind in kinds],
            )
            for k, kinds in zip(picked, self._joints.values())
        ]
        no_values = InterfaceValue()
        message.interface_values += [no_values] * self._n_extra
        return message
