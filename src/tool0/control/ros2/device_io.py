"""Controllers for device inputs and outputs; the ROS node provides their services."""

from __future__ import annotations

from collections.abc import Iterator

from tool0.control.parameters import RobotJoints
from tool0.control.passive import PassiveSpec
from tool0.description.yaml_values import Namespace

_ACTIVATION = ("reactivate_gripper_cmd", "reactivate_gripper_response")


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> PassiveSpec:
    """Return the checked parameters of a controller for inputs and outputs."""
    if type_name.endswith("/GPIOController"):
        prefix = parameters.text("tf_prefix", "")
        parameters.integer("check_io_successfull_retries", 10)
        parameters.boolean("verify_payload_on_set", default=True)
        commands = tuple(f"{prefix}{item}" for item in _box_commands())
        states = tuple(f"{prefix}{item}" for item in _box_states())
    else:
        prefix = _prefix_of_gripper(name, robot)
        parameters.accept("default")
        commands = tuple(f"{prefix}reactivate_gripper/{item}" for item in _ACTIVATION)
        states = ()
    return PassiveSpec(
        name=name, type=type_name, further_interfaces=commands, state_interfaces=states
    )


def _prefix_of_gripper(name: str, robot: RobotJoints) -> str:
    """Return the gripper prefix with which the controller's name starts.

    The controller has no parameter for the prefix.
    """
    prefixes = (
        interface.removesuffix(f"reactivate_gripper/{_ACTIVATION[0]}")
        for component in robot.hardware
        for interface in component.command_interfaces
        if interface.endswith(f"reactivate_gripper/{_ACTIVATION[0]}")
    )
    fitting = (prefix for prefix in prefixes if name.startswith(prefix))
    return max(fitting, key=len, default="")


def _box_commands() -> Iterator[str]:
    """Yield the command interfaces of the Universal Robots driver."""
    for k in range(18):
        yield f"gpio/standard_digital_output_cmd_{k}"
    for k in range(2):
        yield f"gpio/standard_analog_output_cmd_{k}"
    yield "gpio/analog_output_domain_cmd"
    yield "gpio/tool_voltage_cmd"
    yield "gpio/io_async_success"
    yield "speed_scaling/target_speed_fraction_cmd"
    yield "speed_scaling/target_speed_fraction_async_success"
    for name in ("resend_robot_program", "zero_ftsensor", "hand_back_control"):
        yield f"{name}/{name}_cmd"
        yield f"{name}/{name}_async_success"
    yield from _payload()
    yield "payload/transition_time"
    yield "payload/payload_async_success"


def _box_states() -> Iterator[str]:
    """Yield the state interfaces of the Universal Robots driver."""
    counts = {
        **{"digital_output": 18, "digital_input": 18},
        **{"standard_analog_output": 2, "standard_analog_input": 2},
        **{"analog_io_type": 4, "tool_analog_input": 2, "tool_analog_input_type": 2},
        **{"robot_status_bit": 4, "safety_status_bit": 11},
    }
    for name, count in counts.items():
        yield from (f"gpio/{name}_{k}" for k in range(count))
    tool = ("tool_mode", "tool_output_voltage", "tool_output_current")
    modes = ("tool_temperature", "robot_mode", "safety_mode", "program_running")
    yield from (f"gpio/{name}" for name in (*tool, *modes))
    yield "system_interface/initialized"
    yield from _payload()


def _payload() -> Iterator[str]:
    yield "payload/mass"
    yield from (f"payload/cog.{axis}" for axis in "xyz")
    yield from (f"payload/inertia.i{axes}" for axes in ("xx", "yy", "zz"))
    yield from (f"payload/inertia.i{axes}" for axes in ("xy", "xz", "yz"))
