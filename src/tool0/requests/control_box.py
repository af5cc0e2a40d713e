"""Requests to the control box of an arm: pins, payload, program, power and stops."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Final, Generic, Literal

from msgspec import Meta, field

from tool0.hardware.control_box import (
    MAX_REGISTERS,
    N_ANALOG,
    N_DIGITAL,
    AnalogDomain,
    AnalogPin,
    ControlBoxState,
    Pose6,
    UrReport,
)
from tool0.hardware.payload import Payload
from tool0.requests.table import Request, Response, Vector3, handles
from tool0.runtime.arm_modes import ArmModes
from tool0.runtime.simulation import Simulation

DigitalPin = Annotated[int, Meta(ge=0, le=N_DIGITAL - 1)]
"""Standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
AnalogPinNumber = Annotated[int, Meta(ge=0, le=N_ANALOG - 1)]
Fraction = Annotated[float, Meta(ge=0.01, le=1.0)]
MOST_PROGRAM: Final = 200
"""Characters of a program's name."""
MOST_POPUP: Final = 1000
"""Characters of a popup."""
Mass = Annotated[float, Meta(ge=0.0, le=1000.0)]
"""[kg]"""


class _OfArm(Request[Response], Generic[Response], frozen=True, kw_only=True):
    """The fields of every request to a control box."""

    arm: str | None = None
    """As ``list_arms`` names it; the only one, if left out."""


class ReadIO(_OfArm[ControlBoxState], frozen=True):
    """Pins, speed slider, payload, modes and program of an arm."""


class SetIO(_OfArm[None], frozen=True):
    """Set digital outputs and the tool's voltage; what is left out does not change."""

    digital_outputs: dict[DigitalPin, bool] = field(default_factory=dict)
    """By pin: standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
    digital_inputs: dict[DigitalPin, bool] = field(default_factory=dict)
    """What the inputs measure, by pin: for tests, in place of wires."""
    tool_voltage: Literal[0, 12, 24] | None = None
    """At the tool's connector [V]."""


class SetAnalogOutput(_OfArm[None], frozen=True):
    """Set an analogue output of the box."""

    pin: AnalogPinNumber
    level: Annotated[float, Meta(ge=0.0, le=1.0)]
    """Fraction of the range: 0 … 10 V, or 4 … 20 mA."""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """0 is a current, 1 a voltage."""


class SetAnalogInput(_OfArm[None], frozen=True):
    """Set what an analogue input measures: for tests, in place of a wire."""

    pin: AnalogPinNumber
    value: float
    """[V] or [A]"""
    domain: AnalogDomain = AnalogDomain.VOLTAGE
    """0 is a current, 1 a voltage."""
    tool: bool = False
    """Whether it is an input of the tool."""


class SetSpeedSlider(_OfArm[None], frozen=True):
    """Slow down the trajectories of scaled controllers, smoothly, from now on."""

    fraction: Fraction
    """Of the programmed speed."""


class SetPayload(_OfArm[None], frozen=True):
    """Set what the drives expect at the flange, with the gripper and its load.

    It replaces the tool of the description: drives that compensate gravity use it, and
    force-torque sensors subtract its weight and inertia.  The physics does not change.
    """

    mass: Mass | None = None
    """[kg]; what the description has, if left out."""
    center_of_gravity: Vector3 = (0.0, 0.0, 0.0)
    """In the frame of the flange, ``tool0`` [m]."""


class PlayProgram(_OfArm[None], frozen=True):
    """Start or resume the program that lets clients control the arm."""


class PauseProgram(_OfArm[None], frozen=True):
    """Pause the program: scaled trajectories slow down to a standstill."""


class StopProgram(_OfArm[None], frozen=True):
    """Stop the program and what moves the arm; ``play_program`` starts controllers."""


class PowerOff(_OfArm[None], frozen=True):
    """Switch the arm off: its program and its controllers stop, the brakes hold it."""


class PowerOn(_OfArm[None], frozen=True):
    """Switch the arm on; its brakes stay on until ``release_brakes``."""


class ReleaseBrakes(_OfArm[None], frozen=True):
    """Release the brakes, and switch the arm on before, if it is off.

    Nothing moves until ``play_program`` starts the controllers again.
    """


class StopProtectively(_OfArm[None], frozen=True):
    """Stop this arm as its safety system does: it brakes until the stop is unlocked."""

    reason: Annotated[str, Meta(min_length=1, max_length=500)]
    """For people."""


class UnlockProtectiveStop(_OfArm[None], frozen=True):
    """End a protective stop, from 5 s of simulated time after it on.

    The arm holds until ``play_program`` starts the controllers again.
    """


class RestartSafety(_OfArm[None], frozen=True):
    """Clear whatever the safety system has stopped; the arm is switched off then."""


class SetTcp(_OfArm[None], frozen=True):
    """Set the tool centre point, for clients; nothing in the simulation uses it."""

    pose: Pose6
    """In the frame of the flange: position [m] and rotation vector [rad]."""


class SetSafetyLimits(_OfArm[None], frozen=True):
    """Choose what stops the arm protectively by itself; the rest does not change."""

    enabled: bool | None = None
    """Whether anything does: a path error, the force of a contact, a joint's limit."""
    force: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    """Of contacts with the tool or a link but the base [N]."""


class ReportUr(_OfArm[None], frozen=True):
    """Show what the interface of UR's protocols does: for its process only."""

    program: Annotated[str, Meta(max_length=MOST_PROGRAM)] = ""
    """The name of its program; empty if there is none."""
    program_state: Annotated[str, Meta(max_length=50)] = "STOPPED"
    """As RTDE names ``runtime_state``."""
    popup: Annotated[str, Meta(max_length=MOST_POPUP)] | None = None
    """The text that waits for an answer."""
    clients: Annotated[int, Meta(ge=0)] = 0
    """Connections to all of its ports."""
    registers: Annotated[
        Mapping[str, bool | int | float], Meta(max_length=MAX_REGISTERS)
    ] = field(default_factory=dict)
    """Those that are not zero, by their names in RTDE."""


handles(ReadIO, in_tick=True, publishes=False)(
    lambda sim, request: sim.core.control_boxes.find(request.arm)
)


@handles(SetIO, in_tick=True)
def _set_io(simulation: Simulation, request: SetIO) -> None:
    boxes, arm = simulation.core.control_boxes, request.arm
    boxes.find(arm)
    boxes.set_digital(arm, request.digital_outputs, is_input=False)
    boxes.set_digital(arm, request.digital_inputs, is_input=True)
    if request.tool_voltage is not None:
        boxes.set_tool_voltage(arm, request.tool_voltage)


handles(SetAnalogOutput, in_tick=True)(
    lambda sim, request: sim.core.control_boxes.set_analog_output(
        request.arm, request.pin, request.level, request.domain
    )
)
handles(SetAnalogInput, in_tick=True)(
    lambda sim, request: sim.core.control_boxes.set_analog_input(
        request.arm,
        request.pin,
        AnalogPin(request.value, request.domain),
        is_of_tool=request.tool,
    )
)
handles(SetSpeedSlider, in_tick=True)(
    lambda sim, request: sim.core.control_boxes.set_speed_slider(
        request.arm, request.fraction
    )
)


@handles(SetPayload, in_tick=True)
def _set_payload(simulation: Simulation, request: SetPayload) -> None:
    payload = None
    if request.mass is not None:
        payload = Payload(request.mass, request.center_of_gravity)
    simulation.core.set_payload(request.arm, payload)


handles(SetTcp, in_tick=True)(
    lambda sim, request: sim.core.control_boxes.set_tcp(request.arm, request.pose)
)
handles(SetSafetyLimits, in_tick=True)(
    lambda sim, request: sim.core.control_boxes.set_safety_limits(
        request.arm, request.enabled, request.force
    )
)
handles(ReportUr, in_tick=True)(
    lambda sim, request: sim.core.control_boxes.report_ur(
        request.arm,
        UrReport(
            program=request.program,
            program_state=request.program_state,
            popup=request.popup,
            clients=request.clients,
            registers=request.registers,
        ),
    )
)
handles(PauseProgram, in_tick=True)(
    lambda sim, request: sim.core.arm_modes.pause(request.arm)
)
handles(
    StopProtectively,
    in_tick=True,
    urgent=True,
    revokes=("unlock_protective_stop", "restart_safety"),
)(
    lambda sim, request: sim.core.arm_modes.stop_protectively(
        request.arm, request.reason, sim.core.state
    )
)


def _handles_mode(
    kind: type[_OfArm[None]],
    change: Callable[..., None],
    revokes: tuple[str, ...] = (),
) -> None:
    """Let ``kind`` change the mode of its arm; one that revokes others is a stop."""
    handles(kind, in_tick=True, urgent=bool(revokes), revokes=revokes)(
        lambda sim, request: change(sim.core.arm_modes, request.arm, sim.core.state)
    )


_handles_mode(PlayProgram, ArmModes.play)
_handles_mode(StopProgram, ArmModes.stop, ("play_program", "run_program", "take_arm"))
_handles_mode(PowerOff, ArmModes.power_off, ("power_on", "release_brakes"))
_handles_mode(PowerOn, ArmModes.power_on)
_handles_mode(ReleaseBrakes, ArmModes.release_brakes)
_handles_mode(UnlockProtectiveStop, ArmModes.unlock)
_handles_mode(RestartSafety, ArmModes.restart_safety)
