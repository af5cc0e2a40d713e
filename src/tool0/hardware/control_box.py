"""The state of an arm's control box: pins, speed, payload, modes, program.

Numbers are those of Universal Robots' real-time interface (RTDE):
https://docs.universal-robots.com/tutorials/communication-protocol-tutorials/rtde-guide.html
"""

from __future__ import annotations

from enum import Enum, IntEnum
from typing import Final, final

from msgspec import Struct

from tool0.hardware.payload import Payload

N_DIGITAL: Final = 18
"""Digital pins: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
N_ANALOG: Final = 2
"""Analogue pins of the box; the tool has as many inputs again."""
TOOL_VOLTAGES: Final = (0, 12, 24)
"""What the tool's connector can supply [V]."""


class AnalogDomain(IntEnum):
    """What an analogue pin measures or controls."""

    CURRENT = 0
    """4 … 20 mA, given in [A]."""
    VOLTAGE = 1
    """0 … 10 V"""


class RobotMode(IntEnum):
    """Whether the arm is powered; the others of a UR do not occur."""

    POWER_OFF = 3
    RUNNING = 7


class SafetyMode(IntEnum):
    """Why the arm may not move; the others of a UR do not occur."""

    NORMAL = 1
    ROBOT_EMERGENCY_STOP = 7


class ProgramState(Enum):
    """What the program that lets ROS control the arm does."""

    STOPPED = "STOPPED"
    """The controllers of the arm are stopped."""
    PLAYING = "PLAYING"
    PAUSED = "PAUSED"
    """Scaled trajectories stand still."""


@final
class AnalogPin(Struct, frozen=True):
    """An analogue input or output."""

    value: float = 0.0
    """[V] or [A]"""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """Whether it is a current."""


_UNUSED: Final = (AnalogPin(),) * N_ANALOG
_OFF: Final = (False,) * N_DIGITAL


@final
class ControlBoxState(Struct, frozen=True, kw_only=True):
    """The control box of one arm; the same object until something changes."""

    arm: str
    """As ``list_arms`` names it."""
    prefix: str
    """Of the names of its links and joints."""
    digital_inputs: tuple[bool, ...] = _OFF
    """Standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
    digital_outputs: tuple[bool, ...] = _OFF
    """In the same order."""
    analog_inputs: tuple[AnalogPin, ...] = _UNUSED
    """0 and 1"""
    analog_outputs: tuple[AnalogPin, ...] = _UNUSED
    """0 and 1"""
    tool_analog_inputs: tuple[AnalogPin, ...] = _UNUSED
    """2 and 3 in UR's numbering"""
    tool_voltage: int = 0
    """Supplied by the tool's connector [V]: 0, 12 or 24."""
    tool_current: float = 0.0
    """[A]; nothing in the simulation draws any."""
    tool_temperature: float = 25.0
    """[°C]; a constant, room temperature."""
    speed_slider: float = 1.0
    """Fraction of the programmed speed, 0.01 … 1."""
    speed_scaling: float = 1.0
    """The factor that scaled trajectories follow now: the slider's, 0 when paused."""
    payload: Payload
    """What the drives take to be at the flange."""
    robot_mode: RobotMode = RobotMode.RUNNING
    """Whether the arm is powered."""
    safety_mode: SafetyMode = SafetyMode.NORMAL
    """Whether the emergency stop is engaged."""
    program: ProgramState = ProgramState.PLAYING
    """What the program does that lets clients control the arm."""

    @property
    def is_program_running(self) -> bool:
        """Whether ROS controls the arm: the program plays, and the arm is powered."""
        return (
            self.program is ProgramState.PLAYING
            and self.safety_mode is SafetyMode.NORMAL
        )
