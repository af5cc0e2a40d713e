"""Quantities that a control box reports but that tool0 does not measure.

The simulation has no motors, voltages or temperatures. Quantities that depend on
motors, voltages or temperatures are either nominal constants or computed from the drive
efforts with the rules below. Each docstring states whether the quantity is a constant
or computed.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from tool0.protocol.control_box_state import AnalogDomain, RobotMode, SafetyMode
from tool0.protocol.state import Six
from tool0.ur.programs import RuntimeState

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

Three = tuple[float, float, float]

TORQUE_PER_AMPERE: Final = 10.0
"""Torque of a joint per ampere of its motor current [N·m/A].

The value is a convention. The torque constants of UR's motors are not published and
differ between joints. With a gear ratio of 101, the torque constants have the same
order of magnitude as this value. The product of a reported current and this value is
the torque of the drive.
"""
SUPPLY_VOLTAGE: Final = 48.0
"""Nominal supply voltage of the control box, the arm and its motors [V]."""
ROOM_TEMPERATURE: Final = 25.0
"""Temperature of the joints, which is constant in the simulation [°C]."""
GRAVITY: Final = 9.80665
"""Standard gravity, which acts along the z axis of an upright arm's base [m/s²]."""

_STEP: Final = 1e-5
"""Time step for finite differences of velocities [s]."""

JOINT_MODES: Final = {
    RobotMode.POWER_OFF: 239,
    RobotMode.POWER_ON: 247,
    RobotMode.IDLE: 255,
    RobotMode.BACKDRIVE: 238,
    RobotMode.RUNNING: 253,
}
"""UR's joint modes: power off, booting, idle, backdrive and running."""
TOOL_OFF, TOOL_RUNNING = 239, 253

_SAFETY_BITS: Final = {
    SafetyMode.NORMAL: 1 << 0,
    SafetyMode.REDUCED: 1 << 1,
    SafetyMode.PROTECTIVE_STOP: 1 << 2 | 1 << 10,
    SafetyMode.RECOVERY: 1 << 3,
    SafetyMode.SAFEGUARD_STOP: 1 << 4 | 1 << 10,
    SafetyMode.SYSTEM_EMERGENCY_STOP: 1 << 5 | 1 << 7 | 1 << 10,
    SafetyMode.ROBOT_EMERGENCY_STOP: 1 << 6 | 1 << 7 | 1 << 10,
    SafetyMode.VIOLATION: 1 << 8 | 1 << 10,
    SafetyMode.FAULT: 1 << 9 | 1 << 10,
}
"""Bits 0 … 10: normal, reduced, protective stop, recovery, safeguard stop, system
emergency stop, robot emergency stop, any emergency stop, violation, fault, and stopped
due to safety."""


def is_powered(box: UrControlBox) -> bool:
    """Return whether the arm has power."""
    return box.state.robot_mode is not RobotMode.POWER_OFF


def currents(box: UrControlBox) -> Six:
    """Return the motor currents, computed with ``TORQUE_PER_AMPERE`` [A]."""
    a, b, c, d, e, f = (effort / TORQUE_PER_AMPERE for effort in box.effort)
    return (a, b, c, d, e, f)


def robot_current(box: UrControlBox) -> float:
    """Return the arm's supply current: mechanical power divided by voltage [A]."""
    pairs = zip(box.effort, box.qd, strict=True)
    return sum(abs(effort * speed) for effort, speed in pairs) / SUPPLY_VOLTAGE


def voltage(box: UrControlBox) -> float:
    """Return the nominal voltage, or 0 if the arm has no power [V]."""
    return SUPPLY_VOLTAGE if is_powered(box) else 0.0


def joint_modes(box: UrControlBox) -> tuple[int, ...]:
    """Return UR's mode of each joint."""
    return (JOINT_MODES.get(box.state.robot_mode, TOOL_RUNNING),) * 6


def tool_mode(box: UrControlBox) -> int:
    """Return UR's mode of the tool board."""
    return TOOL_RUNNING if is_powered(box) else TOOL_OFF


def robot_status_bits(box: UrControlBox) -> int:
    """Return bits 0 … 3: power on, program running, teach button, power button."""
    running = box.programs.state is RuntimeState.PLAYING
    return int(is_powered(box)) | int(running) << 1


def safety_status_bits(box: UrControlBox) -> int:
    """Return the safety status in the bits that ``_SAFETY_BITS`` defines."""
    return _SAFETY_BITS.get(box.state.safety_mode, 1 << 9)


def digital_bits(levels: tuple[bool, ...]) -> int:
    """Return pin levels as bits: standard 0 … 7, configurable 8 … 15, tool 16, 17."""
    return sum(1 << pin for pin, level in enumerate(levels) if level)


def configurable_bits(levels: tuple[bool, ...]) -> int:
    """Return the configurable pins as bits 0 … 7."""
    return digital_bits(levels) >> 8 & 0xFF


def analog_io_types(box: UrControlBox) -> int:
    """Return bits 0 … 3, which are 1 for pins that measure or output voltages.

    The pins are analog inputs 0 and 1, and analog outputs 0 and 1.
    """
    pins = (*box.state.analog_inputs, *box.state.analog_outputs)
    return sum((pin.domain is AnalogDomain.VOLTAGE) << k for k, pin in enumerate(pins))


def tool_analog_input_types(box: UrControlBox) -> int:
    """Return bits 0 and 1, which are 1 if the tool's analog inputs are voltages."""
    pins = box.state.tool_analog_inputs
    return sum((pin.domain is AnalogDomain.VOLTAGE) << k for k, pin in enumerate(pins))


def tool_accelerometer(box: UrControlBox) -> Three:
    """Return the reading of an accelerometer in the tool [m/s²].

    The reading contains only gravity, not the acceleration of the tool's motion.
    """
    x, y, z = box.tcp_frame().rotation[2]
    return (GRAVITY * x, GRAVITY * y, GRAVITY * z)


def elbow_position(box: UrControlBox) -> Three:
    """Return the position of the elbow (third joint) in the base frame [m]."""
    return box.posture().points[2]


def elbow_velocity(box: UrControlBox) -> Three:
    """Return the velocity of the elbow in the base frame [m/s]."""
    linear, _ = box.posture().velocity(elbow_position(box), box.qd, n_joints=2)
    return linear


def tcp_acceleration(box: UrControlBox, *, target: bool = False) -> Six:
    """Return the acceleration of the TCP in the base frame's axes [m/s², rad/s²].

    The motion is either the measured motion or the setpoint's motion. Joint
    accelerations are not measured, so the setpoint's accelerations are used in both
    cases.
    """
    q, qd = (box.target_q, box.target_qd) if target else (box.q, box.qd)
    changes = zip(q, qd, box.target_qdd, strict=True)
    later = [(x + _STEP * v, v + _STEP * a) for x, v, a in changes]
    now = box.velocity_at(q, qd)
    then = box.velocity_at([x for x, _ in later], [v for _, v in later])
    a, b, c, d, e, f = ((y - x) / _STEP for x, y in zip(now, then, strict=True))
    return (a, b, c, d, e, f)


def tcp_force(box: UrControlBox) -> float:
    """Return the magnitude of the external force at the TCP [N]."""
    return math.hypot(*box.tcp_wrench()[:3])


def payload_moments(box: UrControlBox) -> Six:
    """Return the payload's Ixx, Iyy, Izz, Ixy, Ixz, Iyz at its mass center [kg·m²]."""
    inertia = box.state.payload.inertia
    return (inertia, inertia, inertia, 0.0, 0.0, 0.0)
