"""The topics and services of UR's io_and_status_controller."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from tool0_ros2 import requests
from tool0_ros2.bridge import ControllerContext, Update
from tool0_ros2.control_box import ControlBox, is_program_running
from tool0_ros2.messages import optional_module
from tool0_ros2.requests import AnalogPin, ControlBoxState, Request
from tool0_ros2.services import offer, refused

_DEFAULT = QoSProfile(depth=10)
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@dataclass
class _Topic:
    """A topic that contains a part of the control box's state."""

    publisher: Any
    message_of: Callable[[ControlBoxState], Any]
    message: Any = None
    """The last message that was published."""


class GpioPart:
    """Topics and services for the pins and modes of a control box.

    The pins are published at every update, and the modes are published when they
    change.
    """

    def __init__(self, context: ControllerContext) -> None:
        self._context = context
        prefix = context.parameters.get("tf_prefix") or context.names.prefix
        self._box = ControlBox(context, prefix)
        self._seen: ControlBoxState | None = None
        self._pins = self._pin_topics()
        self._latched = self._mode_topics()
        self._services = [
            offer(context, Trigger, "resend_robot_program", self._resend_program),
            offer(context, Trigger, "hand_back_control", self._hand_back_control),
            offer(context, Trigger, "zero_ftsensor", self._zero_sensor),
        ]
        services = optional_module(context, "ur_msgs.srv", context.name)
        if services is not None:
            self._services += [
                offer(context, services.SetIO, "set_io", self._set_io),
                offer(
                    context,
                    services.SetAnalogOutput,
                    "set_analog_output",
                    self._set_analog,
                ),
                offer(
                    context,
                    services.SetSpeedSliderFraction,
                    "set_speed_slider",
                    self._set_speed,
                ),
                offer(context, services.SetPayload, "set_payload", self._set_payload),
            ]

    def _pin_topics(self) -> list[_Topic]:
        """Return the topics that are published at every update."""
        messages = optional_module(self._context, "ur_msgs.msg", self._context.name)
        if messages is None:
            return []
        create = self._context.node.create_publisher
        return [
            _Topic(create(messages.IOStates, "~/io_states", _DEFAULT), _io_states),
            _Topic(create(messages.ToolDataMsg, "~/tool_data", _DEFAULT), _tool_data),
        ]

    def _mode_topics(self) -> list[_Topic]:
        """Return the topics that are published when their values change."""
        create = self._context.node.create_publisher
        topics = [_Topic(create(Bool, "~/robot_program_running", _LATCHED), _program)]
        module = "ur_dashboard_msgs.msg"
        messages = optional_module(self._context, module, self._context.name)
        if messages is not None:
            topics += [
                _Topic(create(messages.RobotMode, "~/robot_mode", _LATCHED), _robot),
                _Topic(create(messages.SafetyMode, "~/safety_mode", _LATCHED), _safety),
            ]
        return topics

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        state = self._box.state(update)
        if state is not self._seen:
            self._seen = state
            for topic in self._pins:
                topic.message = topic.message_of(state)
            for topic in self._latched:
                message = topic.message_of(state)
                if message != topic.message:
                    topic.message = message
                    topic.publisher.publish(message)
        for topic in self._pins:
            if topic.publisher.get_subscription_count():
                topic.publisher.publish(topic.message)

    def close(self) -> None:
        node = self._context.node
        for topic in (*self._pins, *self._latched):
            node.destroy_publisher(topic.publisher)
        for service in self._services:
            node.destroy_service(service)

    # ---- services -------------------------------------------------------------------

    def _send(self, request: Request[None]) -> None:
        self._context.connection.call(request)

    def _set_output(self, pin: int, level: float, domain: Any) -> None:
        self._send(
            requests.set_analog_output(
                pin=pin, level=level, domain=domain, arm=self._box.arm
            )
        )

    def _set_io(self, request: Any) -> str:
        pin, state, fun = request.pin, request.state, request.fun
        if fun == request.FUN_SET_DIGITAL_OUT:
            self._send(
                requests.set_io(digital_outputs={pin: bool(state)}, arm=self._box.arm)
            )
        elif fun == request.FUN_SET_ANALOG_OUT:
            outputs = self._box.read()["analog_outputs"]
            domain = outputs[pin]["domain"] if 0 <= pin < len(outputs) else 1
            self._set_output(pin, state, domain)
        elif fun == request.FUN_SET_TOOL_VOLTAGE:
            voltage: Any = int(state)  # the bring-up checks the value
            self._send(requests.set_io(tool_voltage=voltage, arm=self._box.arm))
        else:
            raise refused(
                f"fun {fun} is not supported; valid: digital output "
                f"{request.FUN_SET_DIGITAL_OUT}, analog output "
                f"{request.FUN_SET_ANALOG_OUT}, tool voltage "
                f"{request.FUN_SET_TOOL_VOLTAGE}"
            )
        return ""

    def _set_analog(self, request: Any) -> str:
        data = request.data
        self._set_output(data.pin, data.state, data.domain)
        return ""

    def _set_speed(self, request: Any) -> str:
        fraction = request.speed_slider_fraction
        self._send(requests.set_speed_slider(fraction=fraction, arm=self._box.arm))
        return ""

    def _set_payload(self, request: Any) -> str:
        center, rated = request.center_of_gravity, self._box.rated_payload()
        if request.mass > rated:
            raise refused(
                f"a payload of {request.mass:g} kg is more than the arm's rated "
                f"{rated:g} kg"
            )
        self._send(
            requests.set_payload(
                mass=request.mass,
                center_of_gravity=[center.x, center.y, center.z],
                arm=self._box.arm,
            )
        )
        return ""

    def _resend_program(self, request: Any) -> str:
        self._send(requests.play_program(arm=self._box.arm))
        return "the program is running"

    def _hand_back_control(self, request: Any) -> str:
        self._send(requests.stop_program(arm=self._box.arm))
        return "the program has ended"

    def _zero_sensor(self, request: Any) -> str:
        self._send(requests.tare_force_torque(link=self._box.flange))
        return "the sensor is tared"


def _program(state: ControlBoxState) -> Any:
    return Bool(data=is_program_running(state))


def _robot(state: ControlBoxState) -> Any:
    from ur_dashboard_msgs.msg import RobotMode

    return RobotMode(mode=state["robot_mode"])


def _safety(state: ControlBoxState) -> Any:
    from ur_dashboard_msgs.msg import SafetyMode

    return SafetyMode(mode=state["safety_mode"])


def _io_states(state: ControlBoxState) -> Any:
    from ur_msgs.msg import Analog, Digital, IOStates

    def digital(pins: list[bool]) -> list[Any]:
        return [Digital(pin=k, state=value) for k, value in enumerate(pins)]

    def analog(pins: list[AnalogPin]) -> list[Any]:
        return [
            Analog(pin=k, domain=pin["domain"], state=pin["value"])
            for k, pin in enumerate(pins)
        ]

    return IOStates(
        digital_in_states=digital(state["digital_inputs"]),
        digital_out_states=digital(state["digital_outputs"]),
        analog_in_states=analog(state["analog_inputs"]),
        analog_out_states=analog(state["analog_outputs"]),
    )


def _tool_data(state: ControlBoxState) -> Any:
    from ur_msgs.msg import ToolDataMsg

    first, second = state["tool_analog_inputs"]
    return ToolDataMsg(
        analog_input_range2=first["domain"],
        analog_input_range3=second["domain"],
        analog_input2=first["value"],
        analog_input3=second["value"],
        tool_output_voltage=state["tool_voltage"],
        tool_current=state["tool_current"],
        tool_temperature=state["tool_temperature"],
        tool_mode=ToolDataMsg.TOOL_RUNNING_MODE,
    )
