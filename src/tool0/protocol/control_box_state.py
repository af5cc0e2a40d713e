"""State of an arm's control box: pins, speed, payload, modes, program.

The enumerations' numbers are from Universal Robots' real-time interface (RTDE):
https://docs.universal-robots.com/tutorials/communication-protocol-tutorials/rtde-guide.html
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum, IntEnum
from typing import Final, final

from msgspec import Struct, field

from tool0.description.payload import Payload

N_DIGITAL: Final = 18
"""Number of digital pins: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
N_ANALOG: Final = 2
"""Number of analogue inputs (and outputs) of the box; the tool has two more inputs."""


class AnalogDomain(IntEnum):
    """The quantity that an analogue pin measures or controls."""

    CURRENT = 0
    """Current, 4 … 20 mA, given in [A]."""
    VOLTAGE = 1
    """Voltage, 0 … 10 V."""


class RobotMode(IntEnum):
    """Mode of an arm: whether it is powered and its brakes are released."""

    NO_CONTROLLER = -1
    DISCONNECTED = 0
    CONFIRM_SAFETY = 1
    BOOTING = 2
    POWER_OFF = 3
    POWER_ON = 4
    IDLE = 5
    """Powered, with engaged brakes."""
    BACKDRIVE = 6
    """Freedrive: the arm is guided by hand."""
    RUNNING = 7
    UPDATING_FIRMWARE = 8


class SafetyMode(IntEnum):
    """State of the arm's safety system, which may prevent motion."""

    NORMAL = 1
    REDUCED = 2
    PROTECTIVE_STOP = 3
    RECOVERY = 4
    SAFEGUARD_STOP = 5
    SYSTEM_EMERGENCY_STOP = 6
    ROBOT_EMERGENCY_STOP = 7
    VIOLATION = 8
    FAULT = 9


POWERED: Final = (RobotMode.RUNNING, RobotMode.BACKDRIVE)
"""Modes with released brakes."""
UNSTOPPED: Final = (SafetyMode.NORMAL, SafetyMode.REDUCED)
"""Modes in which the arm can move."""


class ProgramState(Enum):
    """State of the program that controls the arm.

    This is the program that lets clients use the controllers or, while the arm is
    taken, the program that took it.
    """

    STOPPED = "STOPPED"
    """The arm's controllers are stopped."""
    PLAYING = "PLAYING"
    PAUSED = "PAUSED"
    """Scaled trajectories are paused."""


MAX_REGISTERS: Final = 448
"""Number of registers: RTDE has 128 bits, 48 integers and 48 floats in each
direction."""


@final
class AnalogPin(Struct, frozen=True):
    """An analogue input or output."""

    value: float = 0.0
    """Value of the pin, [V] or [A] depending on ``domain``."""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """0 for a current, 1 for a voltage."""


Pose6 = tuple[float, float, float, float, float, float]
"""A pose in UR's format: position [m] and rotation vector [rad]."""


@final
class SafetyLimits(Struct, frozen=True, kw_only=True):
    """Limits that stop an arm automatically."""

    is_enabled: bool = False
    """Whether these limits are active; if not, only requests stop the arm."""
    force: float = 150.0
    """Largest contact force except on the base [N]; by default, UR's default preset."""


@final
class UrReport(Struct, frozen=True, kw_only=True):
    """State of the UR protocol interface."""

    program: str = ""
    """Name of the program that the interface runs; empty if there is none."""
    program_state: str = "STOPPED"
    """State of that program, as in RTDE's ``runtime_state``: STOPPED, PLAYING, PAUSED,
    …"""
    popup: str | None = None
    """Text of a popup that waits for an answer; None if there is none."""
    clients: int = 0
    """Number of connections to the interface's ports."""
    registers: Mapping[str, bool | int | float] = field(default_factory=dict)
    """Values of all registers that are not zero, by RTDE name:
    ``output_int_register_0``."""


@final
class RobotLink(Struct, frozen=True, kw_only=True):
    """Connection to a real robot, and whether tool0 may move the robot."""

    address: str
    """Address of the robot's controller."""
    model: str = ""
    """Type that the robot reports, such as ``UR5``; empty until it is known."""
    serial_number: str = ""
    """Serial number of the robot; empty until it is known."""
    software: str = ""
    """Version of PolyScope."""
    is_connected: bool = True
    """Whether states arrive; if not, the last state is shown."""
    is_remote: bool | None = None
    """Whether the robot is under remote control; None if it does not report this
    (CB3)."""
    is_enabled: bool = False
    """Whether tool0 may move the arm, after ``enable_motion``."""
    obstacles: tuple[str, ...] = ()
    """Reasons why ``enable_motion`` would be refused now, and warnings; one sentence
    each."""
    gripper_problem: str = ""
    """Reason why the gripper does not move: no power, activation or connection.  Empty
    if it does, or if there is no gripper."""


_UNUSED: Final = (AnalogPin(),) * N_ANALOG
_OFF: Final = (False,) * N_DIGITAL


@final
class ControlBoxState(Struct, frozen=True, kw_only=True):
    """State of one arm's control box; the same object until something changes."""

    arm: str
    """Name of the arm in ``list_arms``."""
    prefix: str
    """Prefix of the arm's link and joint names."""
    digital_inputs: tuple[bool, ...] = _OFF
    """Digital inputs: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
    digital_outputs: tuple[bool, ...] = _OFF
    """Digital outputs: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
    analog_inputs: tuple[AnalogPin, ...] = _UNUSED
    """Analogue pins Analogue pins 0 and 1.."""
    analog_outputs: tuple[AnalogPin, ...] = _UNUSED
    """Analogue pins 0 and 1."""
    tool_analog_inputs: tuple[AnalogPin, ...] = _UNUSED
    """Analogue inputs of the tool, 2 and 3 in UR's numbering."""
    tool_voltage: int = 0
    """Voltage at the tool's connector [V]: 0, 12 or 24."""
    tool_current: float = 0.0
    """Current that the tool draws [A]; nothing in the simulation draws any."""
    tool_temperature: float = 25.0
    """Temperature of the tool [°C]; constant room temperature in simulation."""
    speed_slider: float = 1.0
    """Fraction of the programmed speed, 0.01 … 1."""
    speed_scaling: float = 1.0
    """Factor by which trajectories are scaled now: the speed slider's, or 0 when
    paused."""
    payload: Payload
    """Payload that the drives assume at the flange."""
    tcp: Pose6 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """Tool centre point in the flange's frame; stored only for clients."""
    robot_mode: RobotMode = RobotMode.RUNNING
    """Whether the arm is powered."""
    safety_mode: SafetyMode = SafetyMode.NORMAL
    """State of the safety system."""
    protective_stop: str = ""
    """Reason for the protective stop; empty if there is none."""
    safety_limits: SafetyLimits = SafetyLimits()
    """Limits that stop the arm automatically."""
    program: ProgramState = ProgramState.PLAYING
    """State of the program that controls the arm."""
    taken_by: str = ""
    """Name of the program that moves the arm instead of controllers; empty if none
    does."""
    motion_failure: str = ""
    """Reason why that program's motion failed, after which nothing moves the arm until
    the program takes it again.  Empty if the motion did not fail."""
    ur: UrReport | None = None
    """State of the UR protocol interface; None unless UR's protocols are served."""
    link: RobotLink | None = None
    """Connection to a real robot; None in a simulation."""

    @property
    def may_move(self) -> bool:
        """Whether the arm is powered, its brakes are off, and no stop is active."""
        return self.robot_mode in POWERED and self.safety_mode in UNSTOPPED

    @property
    def is_program_running(self) -> bool:
        """Whether clients can move the arm through its controllers."""
        is_playing = self.program is ProgramState.PLAYING
        return is_playing and self.may_move and not self.taken_by
