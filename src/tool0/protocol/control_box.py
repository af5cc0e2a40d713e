"""Requests to the control box of an arm: pins, payload, program, power and stops."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Final, Literal

from msgspec import Meta, field

from tool0.protocol.control_box_state import (
    MAX_REGISTERS,
    N_ANALOG,
    N_DIGITAL,
    AnalogDomain,
    ControlBoxState,
    Pose6,
)
from tool0.protocol.request import ArmRequest, Place

DigitalPin = Annotated[int, Meta(ge=0, le=N_DIGITAL - 1)]
"""Standard 0 … 7, configurable 8 … 15, tool 16 and 17."""

AnalogPinNumber = Annotated[int, Meta(ge=0, le=N_ANALOG - 1)]

Fraction = Annotated[float, Meta(ge=0.01, le=1.0)]

MOST_PROGRAM: Final = 200
"""Characters of a program's name."""

MOST_REASON: Final = 500
"""Characters of the reason of a protective stop."""
MOST_POPUP: Final = 1000
"""Characters of a popup."""

Mass = Annotated[float, Meta(ge=0.0, le=1000.0)]
"""Mass [kg]."""


class ReadIO(ArmRequest[ControlBoxState], frozen=True):
    """Pins, speed slider, payload, modes and program of an arm."""


class SetIO(ArmRequest[None], frozen=True):
    """Set digital outputs and the tool's voltage; what is left out does not change."""

    digital_outputs: dict[DigitalPin, bool] = field(default_factory=dict)
    """Levels of the digital outputs by pin: standard 0 … 7, configurable 8 … 15, tool
    16 and 17."""
    digital_inputs: dict[DigitalPin, bool] = field(default_factory=dict)
    """Levels that the inputs measure, by pin: for tests, in place of wires."""
    tool_voltage: Literal[0, 12, 24] | None = None
    """Voltage at the tool's connector [V]."""


class SetAnalogOutput(ArmRequest[None], frozen=True):
    """Set an analogue output of the box."""

    pin: AnalogPinNumber
    level: Annotated[float, Meta(ge=0.0, le=1.0)]
    """Fraction of the range: 0 … 10 V, or 4 … 20 mA."""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """0 is a current, 1 a voltage."""


class SetAnalogInput(ArmRequest[None], frozen=True):
    """Set what an analogue input measures: for tests, in place of a wire."""

    pin: AnalogPinNumber
    value: float
    """Value that the input measures [V] or [A], by ``domain``."""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """0 is a current, 1 a voltage."""
    tool: bool = False
    """Whether it is an input of the tool."""


class SetSpeedSlider(ArmRequest[None], frozen=True):
    """Slow down the trajectories of scaled controllers, smoothly, from now on."""

    fraction: Fraction
    """Fraction of the programmed speed."""


class SetPayload(ArmRequest[None], frozen=True):
    """Set what the drives expect at the flange, with the gripper and its load.

    It replaces the tool of the description: drives that compensate gravity use it, and
    force-torque sensors subtract its weight and inertia.  The physics does not change.
    """

    mass: Mass | None = None
    """Mass of the payload [kg]; as described, if left out."""
    center_of_gravity: Place = (0.0, 0.0, 0.0)
    """Center of gravity in the frame of the flange, ``tool0`` [m]."""


class PlayProgram(ArmRequest[None], frozen=True):
    """Start or resume the program that lets clients control the arm."""


class PauseProgram(ArmRequest[None], frozen=True):
    """Pause the program: scaled trajectories slow down to a standstill."""


class StopProgram(ArmRequest[None], frozen=True):
    """Stop the program and what moves the arm; ``play_program`` starts controllers."""

    is_urgent = True
    revokes = ("play_program", "run_program", "take_arm")


class PowerOff(ArmRequest[None], frozen=True):
    """Switch the arm off: its program and its controllers stop, the brakes hold it."""

    is_urgent = True
    revokes = ("power_on", "release_brakes")


class PowerOn(ArmRequest[None], frozen=True):
    """Switch the arm on; its brakes stay on until ``release_brakes``."""


class ReleaseBrakes(ArmRequest[None], frozen=True):
    """Release the brakes, and switch the arm on before, if it is off.

    Nothing moves until ``play_program`` starts the controllers again.
    """


class StopProtectively(ArmRequest[None], frozen=True):
    """Stop this arm as its safety system does: it brakes until the stop is unlocked."""

    is_urgent = True
    revokes = ("unlock_protective_stop", "restart_safety")

    reason: Annotated[str, Meta(min_length=1, max_length=MOST_REASON)]
    """Reason of the stop, shown to users."""


class UnlockProtectiveStop(ArmRequest[None], frozen=True):
    """End a protective stop, from 5 s of simulated time after it on.

    The arm holds until ``play_program`` starts the controllers again.
    """

    at_once: bool = False
    """Whether to unlock also within these 5 s, which are for people to find the cause.
    UR's primary interface does so."""


class RestartSafety(ArmRequest[None], frozen=True):
    """Clear whatever the safety system has stopped; the arm is switched off then."""


class SetTcp(ArmRequest[None], frozen=True):
    """Set the tool centre point, for clients; nothing in the simulation uses it."""

    pose: Pose6
    """Pose in the frame of the flange: position [m] and rotation vector [rad]."""


class SetSafetyLimits(ArmRequest[None], frozen=True):
    """Configure the automatic protective stops; what is left out does not change."""

    enabled: bool | None = None
    """Whether path errors, contact forces and joint limits stop the arm at all."""
    force: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Largest force of contacts with the tool or a link but the base [N]."""


class ReportUr(ArmRequest[None], frozen=True):
    """Show what the interface of UR's protocols does: for its process only."""

    program: Annotated[str, Meta(max_length=MOST_PROGRAM)] = ""
    """The name of its program; empty if there is none."""
    program_state: Annotated[str, Meta(max_length=50)] = "STOPPED"
    """Program state, by its name in RTDE's ``runtime_state``."""
    popup: Annotated[str, Meta(max_length=MOST_POPUP)] | None = None
    """The text that waits for an answer."""
    clients: Annotated[int, Meta(ge=0)] = 0
    """Connections to all of its ports."""
    registers: Annotated[
        Mapping[str, bool | int | float], Meta(max_length=MAX_REGISTERS)
    ] = field(default_factory=dict)
    """Registers that are not zero, by their names in RTDE."""
