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
"""Number of a digital pin: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""

AnalogPinNumber = Annotated[int, Meta(ge=0, le=N_ANALOG - 1)]

Fraction = Annotated[float, Meta(ge=0.01, le=1.0)]

MOST_PROGRAM: Final = 200
"""Maximum length of a program's name [characters]."""

MOST_REASON: Final = 500
"""Maximum length of a protective stop's reason [characters]."""
MOST_POPUP: Final = 1000
"""Maximum length of a popup's text [characters]."""

Mass = Annotated[float, Meta(ge=0.0, le=1000.0)]
"""Mass [kg]."""


class ReadIO(ArmRequest[ControlBoxState], frozen=True):
    """Read an arm's pins, speed slider, payload, modes and program."""


class SetIO(ArmRequest[None], frozen=True):
    """Set digital outputs and the tool's voltage; omitted values do not change."""

    digital_outputs: dict[DigitalPin, bool] = field(default_factory=dict)
    """Levels of the digital outputs by pin: standard 0 … 7, configurable 8 … 15, tool
    16 and 17."""
    digital_inputs: dict[DigitalPin, bool] = field(default_factory=dict)
    """Simulated levels of the digital inputs by pin, for tests without electrical
    wiring."""
    tool_voltage: Literal[0, 12, 24] | None = None
    """Voltage at the tool's connector [V]."""


class SetAnalogOutput(ArmRequest[None], frozen=True):
    """Set an analog output of the control box."""

    pin: AnalogPinNumber
    level: Annotated[float, Meta(ge=0.0, le=1.0)]
    """Level of the output, as a fraction of its range: 0 … 10 V, or 4 … 20 mA."""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """Quantity of the pin: 0 is a current, 1 is a voltage."""


class SetAnalogInput(ArmRequest[None], frozen=True):
    """Set the value that an analog input measures, for tests without wiring."""

    pin: AnalogPinNumber
    value: float
    """Value that the input measures, [V] or [A] depending on ``domain``."""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """Quantity of the pin: 0 is a current, 1 is a voltage."""
    tool: bool = False
    """Whether the pin is an input of the tool, rather than of the control box."""


class SetSpeedSlider(ArmRequest[None], frozen=True):
    """Set the speed slider; the speed of scaled trajectories changes smoothly."""

    fraction: Fraction
    """Fraction of the programmed speed."""


class SetPayload(ArmRequest[None], frozen=True):
    """Set the payload that the drives assume, including the gripper.

    The payload replaces the mass of the tool in the description: drives use the payload
    to compensate gravity, and force-torque sensors subtract its weight and inertia.
    The physics does not change.
    """

    mass: Mass | None = None
    """Mass of the payload [kg]; the default is the mass of the tool in the robot's
    description."""
    center_of_gravity: Place = (0.0, 0.0, 0.0)
    """Center of gravity in the flange frame, ``tool0`` [m]."""


class PlayProgram(ArmRequest[None], frozen=True):
    """Start or resume the program, so that clients can control the arm."""


class PauseProgram(ArmRequest[None], frozen=True):
    """Pause the program: scaled trajectories decelerate to rest."""


class StopProgram(ArmRequest[None], frozen=True):
    """Stop the program and the arm; ``play_program`` restarts the controllers."""

    is_urgent = True
    revokes = ("play_program", "run_program", "take_arm")


class PowerOff(ArmRequest[None], frozen=True):
    """Switch the arm off: stop its program and controllers, and engage the brakes."""

    is_urgent = True
    revokes = ("power_on", "release_brakes")


class PowerOn(ArmRequest[None], frozen=True):
    """Switch the arm on; the brakes stay engaged until ``release_brakes``."""


class ReleaseBrakes(ArmRequest[None], frozen=True):
    """Release the brakes; if the arm is off, switch it on first.

    The arm does not move until ``play_program`` restarts the controllers.
    """


class StopProtectively(ArmRequest[None], frozen=True):
    """Trigger a protective stop: the arm stays stopped until the stop is unlocked."""

    is_urgent = True
    revokes = ("unlock_protective_stop", "restart_safety")

    reason: Annotated[str, Meta(min_length=1, max_length=MOST_REASON)]
    """Reason for the stop, which is shown to users."""


class UnlockProtectiveStop(ArmRequest[None], frozen=True):
    """End a protective stop that began at least 5 s of simulated time ago.

    The arm holds its position until ``play_program`` restarts the controllers.
    """

    at_once: bool = False
    """Whether to unlock the stop even within the first 5 s, as UR's primary interface
    does.  These 5 s give the user time to find the cause."""


class RestartSafety(ArmRequest[None], frozen=True):
    """Clear all stops and faults of the safety system; the arm is then off."""


class SetTcp(ArmRequest[None], frozen=True):
    """Set the tool center point that clients read; the simulation does not use it."""

    pose: Pose6
    """Pose of the TCP in the flange frame: position [m] and rotation vector [rad]."""


class SetSafetyLimits(ArmRequest[None], frozen=True):
    """Configure the automatic protective stops; omitted values do not change."""

    enabled: bool | None = None
    """Whether path errors, contact forces and joint limits stop the arm."""
    force: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Maximum contact force on the tool or any link except the base [N]."""


class ReportUr(ArmRequest[None], frozen=True):
    """Report the state of the UR protocol interface.

    Only the process of the interface sends this request.
    """

    program: Annotated[str, Meta(max_length=MOST_PROGRAM)] = ""
    """Name of the program that the interface runs; empty if there is no program."""
    program_state: Annotated[str, Meta(max_length=50)] = "STOPPED"
    """State of the program, with the name from RTDE's ``runtime_state``."""
    popup: Annotated[str, Meta(max_length=MOST_POPUP)] | None = None
    """Text of a popup that waits for an answer; None if there is no popup."""
    clients: Annotated[int, Meta(ge=0)] = 0
    """Number of connections to the interface's ports."""
    registers: Annotated[
        Mapping[str, bool | int | float], Meta(max_length=MAX_REGISTERS)
    ] = field(default_factory=dict)
    """Values of all nonzero registers, by RTDE name."""
