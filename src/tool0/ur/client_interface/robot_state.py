"""The robot state packet, which the primary and secondary interfaces send at 10 Hz.

A packet of type 16 consists of sub-packages. Each sub-package starts with its size and
type. The layouts are those of UR's software 5.9 and later. Where the layouts of a CB3
differ, those of software 3.5 and later are used. Source:
https://docs.universal-robots.com/tutorials/communication-protocol-tutorials/primary-secondary-guide.html
"""

from __future__ import annotations

import math
from enum import IntEnum
from struct import Struct
from typing import TYPE_CHECKING, Final

import numpy as np

from tool0.protocol.control_box_state import RobotMode, SafetyMode
from tool0.ur.programs import RuntimeState
from tool0.ur.rtde import quantities as q

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

ROBOT_STATE: Final = 16
_HEADER: Final = Struct(">iB")
_MODE: Final = Struct(">Q7?BB3dB")
_JOINT: Final = Struct(">3d4fB")
_TOOL: Final = Struct(">BBddfBffB")
_MASTERBOARD: Final = Struct(">IIBBddBBdd4fB??I?BB")
_CARTESIAN: Final = Struct(">12d")
_KINEMATICS: Final = Struct(">6I24dI")
_CONFIGURATION: Final = Struct(">12d12d5d24d4i")
_FORCE: Final = Struct(">7d")
_TOOL_CONNECTION: Final = Struct(">?iiiff")


class Package(IntEnum):
    """Types of the sub-packages that are sent; UR reserves types 9 and 10."""

    ROBOT_MODE = 0
    JOINTS = 1
    TOOL = 2
    MASTERBOARD = 3
    CARTESIAN = 4
    KINEMATICS = 5
    CONFIGURATION = 6
    FORCE_MODE = 7
    ADDITIONAL = 8
    TOOL_CONNECTION = 11
    TOOL_MODE = 12


class ControlMode(IntEnum):
    """Control mode of the arm."""

    POSITION = 0
    TEACH = 1
    FORCE = 2


UNCALIBRATED: Final = 0xFFFFFFFF
"""Value of a joint's calibration checksum if the joint is not calibrated."""
VOLTAGE_RANGE: Final = 1
"""UR's number for the 0 … 10 V range of the control box's analog inputs."""
MAX_ACCELERATION: Final = 40.0
"""Largest acceleration of a joint in a UR's configuration [rad/s²]."""
DEFAULTS: Final = (math.radians(60.0), math.radians(80.0), 0.25, 1.2)
"""Default speed and acceleration of the joints [rad/s, rad/s²] and of the tool [m/s,
m/s²], which apply if a program does not specify them."""
EQUIVALENT_RADIUS: Final = 0.25
"""Equivalent radius in a UR's configuration [m]."""
ROBOT_TYPES: Final = {
    "UR5": 1,
    "UR10": 2,
    "UR3": 3,
    "UR16": 4,
    "UR20": 7,
    "UR30": 8,
    "UR15": 9,
}
"""UR's type number for each arm model."""
MASTERBOARD_VERSION, BOX_TYPE, SUB_TYPE = 6, 4, 3
"""Types of the master board and the control box that UR's own simulator reports for an
e-Series robot."""


def robot_state(box: UrControlBox, *, is_first: bool = False) -> bytes:
    """Return a packet with the current state of a control box.

    The first packet of a connection also contains the kinematics and the configuration,
    which do not change.
    """
    packages = [_robot_mode(box), _joints(box), _cartesian(box)]
    if is_first:
        packages.append(_kinematics(box))
    packages += [_masterboard(box), _tool(box)]
    if is_first:
        packages.append(_configuration(box))
    packages += [_force_mode(box), _additional(box)]
    if box.is_e_series:
        packages += [
            _package(
                Package.TOOL_CONNECTION,
                _TOOL_CONNECTION.pack(False, 115200, 0, 1, 1.5, 3.5),
            ),
            _package(Package.TOOL_MODE, bytes((0, 1, 1))),
        ]
    body = b"".join(packages)
    return _HEADER.pack(_HEADER.size + len(body), ROBOT_STATE) + body


def robot_model(box: UrControlBox) -> str:
    """Return UR's name for the arm model: ``UR5`` for both a UR5 and a UR5e."""
    return box.model_name.upper().removesuffix("E") or "UR"


def _package(kind: Package, body: bytes) -> bytes:
    return _HEADER.pack(_HEADER.size + len(body), kind) + body


def _robot_mode(box: UrControlBox) -> bytes:
    state, program = box.state, box.programs.state
    is_stopped = state.safety_mode in (
        SafetyMode.ROBOT_EMERGENCY_STOP,
        SafetyMode.SYSTEM_EMERGENCY_STOP,
    )
    body = _MODE.pack(
        round(box.time * 1e9),
        True,  # a real robot is connected
        True,  # the real robot is enabled
        state.robot_mode >= RobotMode.POWER_ON,
        is_stopped,
        state.safety_mode is SafetyMode.PROTECTIVE_STOP,
        program in (RuntimeState.PLAYING, RuntimeState.PAUSING, RuntimeState.RESUMING),
        program is RuntimeState.PAUSED,
        max(0, state.robot_mode),
        control_mode(box),
        state.speed_slider,
        state.speed_scaling,
        1.0,
        0,
    )
    return _package(Package.ROBOT_MODE, body)


def control_mode(box: UrControlBox) -> ControlMode:
    """Return the arm's control mode."""
    if box.arm_sample.mode == "freedrive":
        return ControlMode.TEACH
    return ControlMode.FORCE if box.arm_sample.force_mode else ControlMode.POSITION


def _joints(box: UrControlBox) -> bytes:
    volts = q.voltage(box)
    joints = zip(
        box.q,
        box.target_q,
        box.qd,
        q.currents(box),
        q.joint_modes(box),
        strict=True,
    )
    return _package(
        Package.JOINTS,
        b"".join(
            _JOINT.pack(actual, target, speed, amps, volts, q.ROOM_TEMPERATURE, 0, mode)
            for actual, target, speed, amps, mode in joints
        ),
    )


def _tool(box: UrControlBox) -> bytes:
    state = box.state
    first, second = state.tool_analog_inputs
    body = _TOOL.pack(
        first.domain,
        second.domain,
        first.value,
        second.value,
        q.voltage(box),
        state.tool_voltage,
        state.tool_current,
        state.tool_temperature,
        q.tool_mode(box),
    )
    return _package(Package.TOOL, body)


def _masterboard(box: UrControlBox) -> bytes:
    state = box.state
    body = _MASTERBOARD.pack(
        q.digital_bits(state.digital_inputs),
        q.digital_bits(state.digital_outputs),
        VOLTAGE_RANGE,
        VOLTAGE_RANGE,
        *(pin.value for pin in state.analog_inputs),
        *(pin.domain for pin in state.analog_outputs),
        *(pin.value for pin in state.analog_outputs),
        q.ROOM_TEMPERATURE,
        q.voltage(box),
        q.robot_current(box),
        0.0,  # current of the pins
        state.safety_mode,
        state.safety_mode is SafetyMode.REDUCED,
        False,  # no interface to injection molding machines
        0,
        False,  # no selector of the operational mode
        0,  # no enabling device
        0,
    )
    return _package(Package.MASTERBOARD, body)


def _cartesian(box: UrControlBox) -> bytes:
    return _package(Package.CARTESIAN, _CARTESIAN.pack(*box.tcp_pose(), *box.tcp))


def _kinematics(box: UrControlBox) -> bytes:
    theta, a, d, alpha = dh_parameters(box)
    body = _KINEMATICS.pack(*(UNCALIBRATED,) * 6, *theta, *a, *d, *alpha, 0)
    return _package(Package.KINEMATICS, body)


def _configuration(box: UrControlBox) -> bytes:
    limits = [joint.limits for joint in box.chain.joints]
    theta, a, d, alpha = dh_parameters(box)
    body = _CONFIGURATION.pack(
        *(bound for limit in limits for bound in (limit.lower, limit.upper)),
        *(bound for limit in limits for bound in (limit.velocity, MAX_ACCELERATION)),
        *DEFAULTS,
        EQUIVALENT_RADIUS,
        *(*a, *d, *alpha, *theta),
        MASTERBOARD_VERSION,
        BOX_TYPE,
        ROBOT_TYPES.get(robot_model(box), 0),
        SUB_TYPE,
    )
    return _package(Package.CONFIGURATION, body)


def _force_mode(box: UrControlBox) -> bytes:
    jacobian = box.chain.forward(np.asarray([box.q])).jacobian[0]
    dexterity = abs(float(np.linalg.det(jacobian)))
    return _package(Package.FORCE_MODE, _FORCE.pack(*box.tcp_wrench(), dexterity))


def _additional(box: UrControlBox) -> bytes:
    is_guided = box.arm_sample.mode == "freedrive"
    body = bytes((is_guided, 1, 0, 0)) if box.is_e_series else bytes((is_guided, 1))
    return _package(Package.ADDITIONAL, body)


Six = tuple[float, float, float, float, float, float]


def dh_parameters(box: UrControlBox) -> tuple[Six, Six, Six, Six]:
    """Return an arm's nominal Denavit-Hartenberg parameters: theta, a, d, alpha.

    The lengths [m] and angles [rad] are computed from the joint axes with all joints at
    zero. The arm must have the kinematic structure of a UR:
    https://www.universal-robots.com/articles/ur/application-installation/dh-parameters-for-calculations-of-kinematics-and-dynamics/
    """
    posture = box.chain.forward(np.zeros((1, 6)))
    axes, points = posture.axes[0], posture.points[0]
    base, tip = box.T_chain_base[:3, 3], posture.T_base_tip[0, :3, 3]

    def along(axis: int, start: np.ndarray, end: np.ndarray) -> float:
        return abs(float(axes[axis] @ (end - start)))

    def between(first: int) -> float:
        """Return the distance between two parallel axes."""
        way = points[first + 1] - points[first]
        return float(np.linalg.norm(way - axes[first] * (axes[first] @ way)))

    a = (0.0, -between(1), -between(2), 0.0, 0.0, 0.0)
    d = (
        along(0, base, points[1]),
        0.0,
        0.0,
        along(1, points[0], points[4]),
        along(4, points[3], points[5]),
        along(5, points[4], tip),
    )
    right = math.pi / 2.0
    return (0.0,) * 6, a, d, (right, 0.0, 0.0, right, -right, 0.0)
