"""RTDE fields that contain the state of a real robot, and their meaning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, final

from tool0.engines.real_robot.control_program import REGISTERS
from tool0.protocol.control_box_state import (
    AnalogDomain,
    AnalogPin,
    ProgramState,
    RobotMode,
    SafetyMode,
)

MOTION: Final = (
    *("timestamp", "actual_q", "actual_qd", "actual_current"),
    *("actual_TCP_pose", "actual_TCP_force"),
    *REGISTERS,
)
STATUS: Final = (
    *("robot_mode", "safety_mode", "runtime_state"),
    *("target_speed_fraction", "speed_scaling"),
    *("actual_digital_input_bits", "actual_digital_output_bits"),
    *("analog_io_types", "standard_analog_input0", "standard_analog_input1"),
    *("standard_analog_output0", "standard_analog_output1"),
    *("tool_analog_input_types", "tool_analog_input0", "tool_analog_input1"),
    *("tool_output_voltage", "tool_output_current", "tool_temperature"),
    *("payload", "payload_cog", "tcp_offset"),
)
EFFORTS: Final = ("actual_current_as_torque", "target_moment")
"""Fields for the joint torques, in order of preference: measured torques (PolyScope
5.23 or newer), and torques computed by the model for the commanded motion."""

INPUTS: Final = {
    "slider": ("speed_slider_mask", "speed_slider_fraction"),
    "standard": ("standard_digital_output_mask", "standard_digital_output"),
    "configurable": ("configurable_digital_output_mask", "configurable_digital_output"),
    "analog": (
        *("standard_analog_output_mask", "standard_analog_output_type"),
        *("standard_analog_output_0", "standard_analog_output_1"),
    ),
}
"""Fields that tool0 writes, by kind.  There is one recipe for each kind, so that
writing one kind does not change the fields of another kind."""

_PLAYING, _PAUSED = frozenset({2, 5}), frozenset({3, 4})
"""Values of RTDE's ``runtime_state`` for playing and resuming, and for pausing and
paused.  The other values mean stopping and stopped."""


@final
class Fields:
    """Access to the flat values of a package by field name."""

    def __init__(self, columns: Mapping[str, slice]) -> None:
        self._columns = columns
        self._status = [columns[name] for name in STATUS if name in columns]

    def vector(self, package: Sequence[Any], name: str) -> tuple[float, ...]:
        """Return the numbers of a field."""
        return tuple(package[self._columns[name]])

    def number(self, package: Sequence[Any], name: str) -> Any:
        """Return the number of a field, or 0 if the robot does not have the field."""
        column = self._columns.get(name)
        return 0 if column is None else package[column.start]

    def status(self, package: Sequence[Any]) -> tuple[Any, ...]:
        """Return the values that rarely change, for comparison with previous values."""
        return tuple(package[column] for column in self._status)

    def boxes(self, package: Sequence[Any]) -> dict[str, Any]:
        """Return the fields of a ``RobotReport`` that RTDE has."""

        def pins(names: Sequence[str], types: str) -> tuple[AnalogPin, ...]:
            kinds = self.number(package, types)
            return tuple(
                AnalogPin(self.number(package, name), AnalogDomain(kinds >> k & 1))
                for k, name in enumerate(names)
            )

        def bits(name: str) -> tuple[bool, ...]:
            value = self.number(package, name)
            return tuple(bool(value >> k & 1) for k in range(18))

        kinds = self.number(package, "analog_io_types")
        outputs = tuple(
            AnalogPin(
                self.number(package, f"standard_analog_output{k}"),
                AnalogDomain(kinds >> (2 + k) & 1),
            )
            for k in range(2)
        )
        return {
            "robot_mode": RobotMode(self.number(package, "robot_mode")),
            "safety_mode": _safety_mode(self.number(package, "safety_mode")),
            "program": program_state(self.number(package, "runtime_state")),
            "speed_slider": self.number(package, "target_speed_fraction"),
            "speed_scaling": self.number(package, "speed_scaling"),
            "digital_inputs": bits("actual_digital_input_bits"),
            "digital_outputs": bits("actual_digital_output_bits"),
            "analog_inputs": pins(
                ("standard_analog_input0", "standard_analog_input1"), "analog_io_types"
            ),
            "analog_outputs": outputs,
            "tool_analog_inputs": pins(
                ("tool_analog_input0", "tool_analog_input1"), "tool_analog_input_types"
            ),
            "tool_voltage": self.number(package, "tool_output_voltage"),
            "tool_current": self.number(package, "tool_output_current"),
            "tool_temperature": self.number(package, "tool_temperature"),
            "payload_mass": self.number(package, "payload"),
            "payload_center": self.vector(package, "payload_cog"),
            "tcp": self.vector(package, "tcp_offset"),
        }


def program_state(number: int) -> ProgramState:
    """Return the state of a controller's program for RTDE's ``runtime_state``."""
    if number in _PLAYING:
        return ProgramState.PLAYING
    return ProgramState.PAUSED if number in _PAUSED else ProgramState.STOPPED


def _safety_mode(number: int) -> SafetyMode:
    """Return the safety mode; RTDE values 10 and 11 are other safeguard stops."""
    if number in {10, 11}:
        return SafetyMode.SAFEGUARD_STOP
    try:
        return SafetyMode(number)
    except ValueError:
        return SafetyMode.FAULT
