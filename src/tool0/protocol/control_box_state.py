"""State of the control box of an arm: pins, speed, payload, modes and program.

The numbers of the enumerations are from Universal Robots' Real-Time Data Exchange
(RTDE):
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
"""Number of the control box's analog inputs, and also of its analog outputs; the tool
has two more inputs."""


class AnalogDomain(IntEnum):
    """The quantity that an analog pin measures or controls."""

    CURRENT = 0
    """Current, 4 … 20 mA; values are in [A]."""
    VOLTAGE = 1
    """Voltage, 0 … 10 V; values are in [V]."""


class RobotMode(IntEnum):
    """Mode of an arm: whether it is powered and its brakes are released."""

    NO_CONTROLLER = -1
    DISCONNECTED = 0
    CONFIRM_SAFETY = 1
    BOOTING = 2
    POWER_OFF = 3
    POWER_ON = 4
    IDLE = 5
    """The arm is powered, and the brakes are engaged."""
    BACKDRIVE = 6
    """Freedrive: the arm is guided by hand."""
    RUNNING = 7
    UPDATING_FIRMWARE = 8


class SafetyMode(IntEnum):
    """State of the arm's safety system, which can prevent motion."""

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
"""Robot modes with released brakes."""
UNSTOPPED: Final = (SafetyMode.NORMAL, SafetyMode.REDUCED)
"""Safety modes in which the arm can move."""


class ProgramState(Enum):
    """State of the program that controls the arm.

    While the arm is taken, the state refers to the program that took the arm.
    Otherwise, the state refers to the program that allows clients to use the
    controllers.
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
    """An analog input or output."""

    value: float = 0.0
    """Value of the pin: [V] or [A], depending on ``domain``."""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """Quantity of the pin: 0 is a current, 1 is a voltage."""


Pose6 = tuple[float, float, float, float, float, float]
"""A pose in the format of UR: position [m] and rotation vector [rad]."""


@final
class SafetyLimits(Struct, frozen=True, kw_only=True):
    """Limits that stop an arm automatically."""

    is_enabled: bool = False
    """Whether these limits are active; otherwise, only requests stop the arm."""
    force: float = 150.0
    """Maximum contact force on any link except the base [N]; the default is from UR's
    default safety preset."""


@final
class UrReport(Struct, frozen=True, kw_only=True):
    """State of the UR protocol interface."""

    program: str = ""
    """Name of the program that the interface runs; empty if there is no program."""
    program_state: str = "STOPPED"
    """State of the program, with the name from RTDE's ``runtime_state``: STOPPED,
    PLAYING, PAUSED, …"""
    popup: str | None = None
    """Text of a popup that waits for an answer; None if there is no popup."""
    clients: int = 0
    """Number of connections to the interface's ports."""
    registers: Mapping[str, bool | int | float] = field(default_factory=dict)
    """Values of all nonzero registers, by RTDE name, such as
    ``output_int_register_0``."""


@final
class RobotLink(Struct, frozen=True, kw_only=True):
    """Connection to a real robot, and whether tool0 may move the robot."""

    address: str
    """Address of the robot's controller."""
    model: str = ""
    """Type that the robot reports, such as ``UR5``; empty until the type is known."""
    serial_number: str = ""
    """Serial number of the robot; empty until the number is known."""
    software: str = ""
    """Version of the robot's PolyScope software."""
    is_connected: bool = True
    """Whether states are received from the robot; otherwise, the last received state is
    shown."""
    is_remote: bool | None = None
    """Whether the robot is under remote control; None if the robot does not report this
    (CB3)."""
    is_enabled: bool = False
    """Whether ``enable_motion`` has allowed tool0 to move the arm."""
    obstacles: tuple[str, ...] = ()
    """Reasons why ``enable_motion`` would be refused at present, and warnings; each
    item is one sentence."""
    gripper_problem: str = ""
    """Reason why the gripper cannot move: no power, activation or connection.  Empty if
    the gripper can move, or if there is no gripper."""


_UNUSED: Final = (AnalogPin(),) * N_ANALOG
_OFF: Final = (False,) * N_DIGITAL


@final
class ControlBoxState(Struct, frozen=True, kw_only=True):
    """State of one arm's control box.

    The state is the same object until a value changes.
    """

    arm: str
    """Name of the arm in ``list_arms``."""
    prefix: str
    """Prefix of the arm's link and joint names."""
    digital_inputs: tuple[bool, ...] = _OFF
    """Digital inputs: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
    digital_outputs: tuple[bool, ...] = _OFF
    """Digital outputs: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
    analog_inputs: tuple[AnalogPin, ...] = _UNUSED
    """Analog inputs 0 and 1 of the control box."""
    analog_outputs: tuple[AnalogPin, ...] = _UNUSED
    """Analog outputs 0 and 1 of the control box."""
    tool_analog_inputs: tuple[AnalogPin, ...] = _UNUSED
    """Analog inputs of the tool, with the numbers 2 and 3 in UR's protocols."""
    tool_voltage: int = 0
    """Voltage at the tool's connector [V]: 0, 12 or 24."""
    tool_current: float = 0.0
    """Current that the tool draws [A]; always 0 in simulation."""
    tool_temperature: float = 25.0
    """Temperature of the tool [°C]; in simulation, the value is a constant room
    temperature."""
    speed_slider: float = 1.0
    """Position of the speed slider: fraction of the programmed speed, 0.01 … 1."""
    speed_scaling: float = 1.0
    """Present speed factor of trajectories: the value of the speed slider, or 0 during
    a pause."""
    payload: Payload
    """Payload that the drives assume at the flange."""
    tcp: Pose6 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """Tool center point in the flange frame: position [m] and rotation vector [rad].
    The value is stored only for clients."""
    robot_mode: RobotMode = RobotMode.RUNNING
    """Mode of the arm: whether it is powered and its brakes are released."""
    safety_mode: SafetyMode = SafetyMode.NORMAL
    """State of the safety system."""
    protective_stop: str = ""
    """Reason for the protective stop; empty if there is no protective stop."""
    safety_limits: SafetyLimits = SafetyLimits()
    """Limits that stop the arm automatically."""
    program: ProgramState = ProgramState.PLAYING
    """State of the program that controls the arm."""
    taken_by: str = ""
    """Name of the program that moves the arm in place of the controllers; empty if the
    arm is not taken."""
    motion_failure: str = ""
    """Reason why a motion of the program ``taken_by`` failed.  The arm then does not
    move until the program takes it again.  Empty if no motion failed."""
    ur: UrReport | None = None
    """State of the UR protocol interface; None if UR's protocols are not served."""
    link: RobotLink | None = None
    """Connection to a real robot; None in a simulation."""

    @property
    def may_move(self) -> bool:
        """Whether the arm is powered, with released brakes and no active stop."""
        return self.robot_mode in POWERED and self.safety_mode in UNSTOPPED

    @property
    def is_program_running(self) -> bool:
        """Whether clients can move the arm through its controllers."""
        is_playing = self.program is ProgramState.PLAYING
        return is_playing and self.may_move and not self.taken_by
