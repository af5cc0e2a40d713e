"""The state of an arm's control box: pins, speed, payload, modes, program.

Numbers are those of Universal Robots' real-time interface (RTDE):
https://docs.universal-robots.com/tutorials/communication-protocol-tutorials/rtde-guide.html
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum, IntEnum
from typing import Final, final

from msgspec import Struct, field

from tool0.description.payload import Payload

N_DIGITAL: Final = 18
"""Digital pins: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
N_ANALOG: Final = 2
"""Analogue pins of the box; the tool has as many inputs again."""


class AnalogDomain(IntEnum):
    """The quantity that an analogue pin measures or controls."""

    CURRENT = 0
    """4 … 20 mA, given in [A]."""
    VOLTAGE = 1
    """0 … 10 V"""


class RobotMode(IntEnum):
    """Whether the arm is powered, and its brakes are released."""

    NO_CONTROLLER = -1
    DISCONNECTED = 0
    CONFIRM_SAFETY = 1
    BOOTING = 2
    POWER_OFF = 3
    POWER_ON = 4
    IDLE = 5
    """Powered, with its brakes on."""
    BACKDRIVE = 6
    """Guided by hand."""
    RUNNING = 7
    UPDATING_FIRMWARE = 8


class SafetyMode(IntEnum):
    """Why the arm may not move."""

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
"""Modes in which the arm may move."""


class ProgramState(Enum):
    """State of the program that controls the arm.

    It is the one that lets clients use the controllers, or, while the arm is taken, the
    one that took it.
    """

    STOPPED = "STOPPED"
    """The controllers of the arm are stopped."""
    PLAYING = "PLAYING"
    PAUSED = "PAUSED"
    """Scaled trajectories stand still."""


MAX_REGISTERS: Final = 448
"""RTDE has 128 bits, 48 integers and 48 floating-point numbers in each direction."""


@final
class AnalogPin(Struct, frozen=True):
    """An analogue input or output."""

    value: float = 0.0
    """Value of the pin [V] or [A], by ``domain``."""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """0 is a current, 1 a voltage."""


Pose6 = tuple[float, float, float, float, float, float]
"""A pose as UR writes it: position [m] and rotation vector [rad]."""


@final
class SafetyLimits(Struct, frozen=True, kw_only=True):
    """Limits that stop an arm automatically."""

    is_enabled: bool = False
    """Whether anything does; without it, only requests stop the arm."""
    force: float = 150.0
    """Largest contact force, but at the base [N]; a UR's default preset."""


@final
class UrReport(Struct, frozen=True, kw_only=True):
    """State of the interface of UR's protocols."""

    program: str = ""
    """The name of its program; empty if there is none."""
    program_state: str = "STOPPED"
    """RTDE's ``runtime_state``: STOPPED, PLAYING, PAUSED, …"""
    popup: str | None = None
    """The text that waits for an answer."""
    clients: int = 0
    """Connections to all of its ports."""
    registers: Mapping[str, bool | int | float] = field(default_factory=dict)
    """Registers that are not zero, by name in RTDE: ``output_int_register_0``."""


@final
class RobotLink(Struct, frozen=True, kw_only=True):
    """The connection to a real robot, and whether tool0 may move it."""

    address: str
    """Address of the robot's controller."""
    model: str = ""
    """Type of the robot as it reports it, such as ``UR5``; empty until it is known."""
    serial_number: str = ""
    """Serial number of the robot; empty until it is known."""
    software: str = ""
    """Version of PolyScope."""
    is_connected: bool = True
    """Whether states arrive; without them, the last ones are shown."""
    is_remote: bool | None = None
    """Whether the robot is under remote control; None if it does not say so (CB3)."""
    is_enabled: bool = False
    """Whether tool0 may move the arm, since ``enable_motion``."""
    obstacles: tuple[str, ...] = ()
    """Why ``enable_motion`` would be refused now, or what the user should know: a
    sentence each."""
    gripper_problem: str = ""
    """Why the gripper does not move: no power, no activation, no connection.  Empty if
    it does, or there is none."""


_UNUSED: Final = (AnalogPin(),) * N_ANALOG
_OFF: Final = (False,) * N_DIGITAL


@final
class ControlBoxState(Struct, frozen=True, kw_only=True):
    """The control box of one arm; the same object until something changes."""

    arm: str
    """Name of the arm in ``list_arms``."""
    prefix: str
    """Prefix of the names of its links and joints."""
    digital_inputs: tuple[bool, ...] = _OFF
    """Standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
    digital_outputs: tuple[bool, ...] = _OFF
    """Digital outputs, in the same order."""
    analog_inputs: tuple[AnalogPin, ...] = _UNUSED
    """0 and 1"""
    analog_outputs: tuple[AnalogPin, ...] = _UNUSED
    """0 and 1"""
    tool_analog_inputs: tuple[AnalogPin, ...] = _UNUSED
    """2 and 3 in UR's numbering"""
    tool_voltage: int = 0
    """Supplied by the tool's connector [V]: 0, 12 or 24."""
    tool_current: float = 0.0
    """Current of the tool [A]; nothing in the simulation draws any."""
    tool_temperature: float = 25.0
    """Temperature of the tool [°C]; a constant, room temperature."""
    speed_slider: float = 1.0
    """Fraction of the programmed speed, 0.01 … 1."""
    speed_scaling: float = 1.0
    """The factor that scaled trajectories follow now: the slider's, 0 when paused."""
    payload: Payload
    """Payload that the drives assume at the flange."""
    tcp: Pose6 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """The tool centre point, in the frame of the flange; stored for clients."""
    robot_mode: RobotMode = RobotMode.RUNNING
    """Whether the arm is powered."""
    safety_mode: SafetyMode = SafetyMode.NORMAL
    """Why it may not move."""
    protective_stop: str = ""
    """Why the arm is in a protective stop; empty if it is not."""
    safety_limits: SafetyLimits = SafetyLimits()
    """Limits that stop the arm automatically."""
    program: ProgramState = ProgramState.PLAYING
    """State of the program that controls the arm."""
    taken_by: str = ""
    """The program that moves the arm in place of controllers; empty without one."""
    motion_failure: str = ""
    """Why the motion of that program failed: nothing moves the arm until the program
    takes it again.  Empty if it did not."""
    ur: UrReport | None = None
    """State of UR's protocols; None unless they are served."""
    link: RobotLink | None = None
    """The connection to a real robot; None in a simulation."""

    @property
    def may_move(self) -> bool:
        """Whether the arm is powered, its brakes are released, and no stop is on."""
        return self.robot_mode in POWERED and self.safety_mode in UNSTOPPED

    @property
    def is_program_running(self) -> bool:
        """Whether clients can move the arm through its controllers."""
        is_playing = self.program is ProgramState.PLAYING
        return is_playing and self.may_move and not self.taken_by
