"""The fields that RTDE clients can receive.

The names and types follow UR's guide. Every control box offers the fields of the
e-Series. Some fields have no meaning in a simulation and are therefore constant: the
encoders, the interface to injection molding machines, the momentum, the energies, the
current window, the deviation and collision ratios, the forces on the base, and the
execution times.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from struct import Struct
from typing import TYPE_CHECKING, Any, Final, NamedTuple, final

from tool0.devices.rtde_packets import LENGTHS, layout
from tool0.ur.registers import N_BITS, N_NUMBERS
from tool0.ur.rtde import quantities as q

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox
    from tool0.ur.registers import RegisterBank

NOT_FOUND: Final = "NOT_FOUND"
FIRST_SINGLE_BIT: Final = 64
"""First boolean register that has a field. Lower boolean registers are sent in groups
of 32."""


Read = Callable[["UrControlBox"], Any]
Bank = Callable[["UrControlBox"], "RegisterBank"]


class OutputField(NamedTuple):
    """Type of a field, and the function that returns its value or vector."""

    type: str
    read: Read


_BANKS: Final[dict[str, Bank]] = {
    "input": lambda box: box.registers.inputs,
    "output": lambda box: box.registers.outputs,
}


def _read_bits(bank: Bank, start: int) -> Read:
    return lambda box: q.digital_bits(tuple(bank(box).bits[start : start + 32]))


def _read_bit(bank: Bank, k: int) -> Read:
    return lambda box: bank(box).bits[k]


def _read_integer(bank: Bank, k: int) -> Read:
    return lambda box: bank(box).integers[k]


def _read_double(bank: Bank, k: int) -> Read:
    return lambda box: bank(box).doubles[k]


def _registers(direction: str) -> dict[str, OutputField]:
    """Return the register fields of a direction; clients can read both directions."""
    bank = _BANKS[direction]
    fields = {
        f"{direction}_bit_registers{start}_to_{start + 31}": OutputField(
            "UINT32", _read_bits(bank, start)
        )
        for start in (0, 32)
    }
    for k in range(FIRST_SINGLE_BIT, N_BITS):
        name = f"{direction}_bit_register_{k}"
        fields[name] = OutputField("BOOL", _read_bit(bank, k))
    for k in range(N_NUMBERS):
        name = f"{direction}_int_register_{k}"
        fields[name] = OutputField("INT32", _read_integer(bank, k))
        name = f"{direction}_double_register_{k}"
        fields[name] = OutputField("DOUBLE", _read_double(bank, k))
    return fields


def _constant(kind: str, value: Any) -> OutputField:
    return OutputField(kind, lambda box: value)


OUTPUTS: Final[dict[str, OutputField]] = {
    "timestamp": OutputField("DOUBLE", lambda box: box.time),
    # ---- joints ----
    "target_q": OutputField("VECTOR6D", lambda box: box.target_q),
    "target_qd": OutputField("VECTOR6D", lambda box: box.target_qd),
    "target_qdd": OutputField("VECTOR6D", lambda box: box.target_qdd),
    "target_current": OutputField("VECTOR6D", q.currents),
    "target_moment": OutputField("VECTOR6D", lambda box: box.effort),
    "actual_q": OutputField("VECTOR6D", lambda box: box.q),
    "actual_qd": OutputField("VECTOR6D", lambda box: box.qd),
    "actual_current": OutputField("VECTOR6D", q.currents),
    "actual_current_window": _constant("VECTOR6D", (0.0,) * 6),
    "actual_current_as_torque": OutputField("VECTOR6D", lambda box: box.effort),
    "joint_control_output": OutputField("VECTOR6D", q.currents),
    "joint_position_deviation_ratio": _constant("DOUBLE", 0.0),
    "joint_temperatures": _constant("VECTOR6D", (q.ROOM_TEMPERATURE,) * 6),
    "joint_mode": OutputField("VECTOR6INT32", q.joint_modes),
    "actual_joint_voltage": OutputField("VECTOR6D", lambda box: (q.voltage(box),) * 6),
    # ---- tool center point ----
    "actual_TCP_pose": OutputField("VECTOR6D", lambda box: box.tcp_pose()),
    "actual_TCP_speed": OutputField("VECTOR6D", lambda box: box.tcp_speed()),
    "actual_TCP_force": OutputField("VECTOR6D", lambda box: box.tcp_wrench()),
    "target_TCP_pose": OutputField("VECTOR6D", lambda box: box.tcp_pose(target=True)),
    "target_TCP_speed": OutputField("VECTOR6D", lambda box: box.tcp_speed(target=True)),
    "actual_TCP_acceleration": OutputField("VECTOR6D", q.tcp_acceleration),
    "target_TCP_acceleration": OutputField(
        "VECTOR6D", lambda box: q.tcp_acceleration(box, target=True)
    ),
    "wrench_calc_from_currents": OutputField("VECTOR6D", lambda box: box.tcp_wrench()),
    "tcp_force_scalar": OutputField("DOUBLE", q.tcp_force),
    "tcp_offset": OutputField("VECTOR6D", lambda box: box.tcp),
    "ft_raw_wrench": OutputField("VECTOR6D", lambda box: box.arm_sample.wrench),
    "elbow_position": OutputField("VECTOR3D", q.elbow_position),
    "elbow_velocity": OutputField("VECTOR3D", q.elbow_velocity),
    "actual_tool_accelerometer": OutputField("VECTOR3D", q.tool_accelerometer),
    "payload": OutputField("DOUBLE", lambda box: box.state.payload.mass),
    "payload_cog": OutputField(
        "VECTOR3D", lambda box: box.state.payload.center_of_gravity
    ),
    "payload_inertia": OutputField("VECTOR6D", q.payload_moments),
    # ---- modes and the program ----
    "robot_mode": OutputField("INT32", lambda box: int(box.state.robot_mode)),
    "safety_mode": OutputField("INT32", lambda box: int(box.state.safety_mode)),
    "safety_status": OutputField("INT32", lambda box: int(box.state.safety_mode)),
    "robot_status_bits": OutputField("UINT32", q.robot_status_bits),
    "safety_status_bits": OutputField("UINT32", q.safety_status_bits),
    "runtime_state": OutputField("UINT32", lambda box: int(box.programs.state)),
    "speed_scaling": OutputField("DOUBLE", lambda box: box.state.speed_scaling),
    "target_speed_fraction": OutputField("DOUBLE", lambda box: box.state.speed_slider),
    "script_control_line": _constant("UINT32", 0),
    "actual_execution_time": _constant("DOUBLE", 0.0),
    "target_execution_time": _constant("DOUBLE", 0.0),
    "control_step": OutputField("UINT64", lambda box: round(box.time * box.rate)),
    "time_scale_source": _constant("INT32", 0),
    "collision_detection_ratio": _constant("DOUBLE", 0.0),
    "actual_momentum": _constant("DOUBLE", 0.0),
    # ---- the base ----
    "target_gravity": _constant("VECTOR3D", (0.0, 0.0, q.GRAVITY)),
    "target_base_acceleration": _constant("VECTOR6D", (0.0,) * 6),
    "target_base_wrench": _constant("VECTOR6D", (0.0,) * 6),
    # ---- supply ----
    "actual_robot_energy_consumed": _constant("DOUBLE", 0.0),
    "actual_robot_braking_energy_dissipated": _constant("DOUBLE", 0.0),
    "actual_main_voltage": _constant("DOUBLE", q.SUPPLY_VOLTAGE),
    "actual_robot_voltage": OutputField("DOUBLE", q.voltage),
    "actual_robot_current": OutputField("DOUBLE", q.robot_current),
    "io_current": _constant("DOUBLE", 0.0),
    # ---- pins ----
    "actual_digital_input_bits": OutputField(
        "UINT64", lambda box: q.digital_bits(box.state.digital_inputs)
    ),
    "actual_digital_output_bits": OutputField(
        "UINT64", lambda box: q.digital_bits(box.state.digital_outputs)
    ),
    "actual_configurable_digital_input_bits": OutputField(
        "UINT64", lambda box: q.configurable_bits(box.state.digital_inputs)
    ),
    "actual_configurable_digital_output_bits": OutputField(
        "UINT64", lambda box: q.configurable_bits(box.state.digital_outputs)
    ),
    "analog_io_types": OutputField("UINT32", q.analog_io_types),
    "standard_analog_input0": OutputField(
        "DOUBLE", lambda box: box.state.analog_inputs[0].value
    ),
    "standard_analog_input1": OutputField(
        "DOUBLE", lambda box: box.state.analog_inputs[1].value
    ),
    "standard_analog_output0": OutputField(
        "DOUBLE", lambda box: box.state.analog_outputs[0].value
    ),
    "standard_analog_output1": OutputField(
        "DOUBLE", lambda box: box.state.analog_outputs[1].value
    ),
    # ---- the tool's connector ----
    "tool_mode": OutputField("UINT32", q.tool_mode),
    "tool_analog_input_types": OutputField("UINT32", q.tool_analog_input_types),
    "tool_analog_input0": OutputField(
        "DOUBLE", lambda box: box.state.tool_analog_inputs[0].value
    ),
    "tool_analog_input1": OutputField(
        "DOUBLE", lambda box: box.state.tool_analog_inputs[1].value
    ),
    "tool_output_voltage": OutputField("INT32", lambda box: box.state.tool_voltage),
    "tool_output_current": OutputField("DOUBLE", lambda box: box.state.tool_current),
    "tool_temperature": OutputField("DOUBLE", lambda box: box.state.tool_temperature),
    "tool_output_mode": _constant("UINT8", 0),
    "tool_digital_output0_mode": _constant("UINT8", 0),
    "tool_digital_output1_mode": _constant("UINT8", 0),
    # ---- not simulated ----
    "encoder0_raw": _constant("INT32", 0),
    "encoder1_raw": _constant("INT32", 0),
    "euromap67_input_bits": _constant("UINT32", 0),
    "euromap67_output_bits": _constant("UINT32", 0),
    "euromap67_24V_voltage": _constant("DOUBLE", 0.0),
    "euromap67_24V_current": _constant("DOUBLE", 0.0),
    **_registers("input"),
    **_registers("output"),
}
"""Output fields by name."""


def output_types(names: Sequence[str]) -> tuple[str, ...]:
    """Return the type of each field; the type of an unknown field is ``NOT_FOUND``."""
    return tuple(OUTPUTS[name].type if name in OUTPUTS else NOT_FOUND for name in names)


@final
class OutputRecipe:
    """Packs the same fields at every update; equal recipes yield equal bytes."""

    def __init__(self, names: Sequence[str], *, recipe_id: int | None) -> None:
        """Prepare to pack known fields; ``recipe_id`` comes first if it is not None."""
        self._key = (recipe_id, tuple(names))
        fields = [OUTPUTS[name] for name in names]
        self._reads = [(field.read, LENGTHS[field.type] > 1) for field in fields]
        self._layout: Struct = layout(
            [field.type for field in fields], recipe_id=recipe_id is not None
        )
        self._start = [] if recipe_id is None else [recipe_id]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, OutputRecipe) and other._key == self._key

    def __hash__(self) -> int:
        return hash(self._key)

    def pack(self, box: UrControlBox) -> bytes:
        """Return the values as the payload of a data packet."""
        values: list[Any] = self._start.copy()
        for read, is_vector in self._reads:
            if is_vector:
                values += read(box)
            else:
                values.append(read(box))
        return self._layout.pack(*values)
