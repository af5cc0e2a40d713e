"""Requests to the control box of an arm: pins, speed slider, payload, program."""

from __future__ import annotations

from typing import Annotated, Any, Generic, Literal

from msgspec import Meta, field

from tool0.hardware.control_box import (
    N_ANALOG,
    N_DIGITAL,
    AnalogDomain,
    AnalogPin,
    ControlBoxState,
)
from tool0.hardware.payload import Payload
from tool0.requests.table import Request, Response, Vector3, handles
from tool0.runtime.simulation import Simulation

DigitalPin = Annotated[int, Meta(ge=0, le=N_DIGITAL - 1)]
"""Standard 0 … 7, configurable 8 … 15, tool 16 and 17."""
AnalogPinNumber = Annotated[int, Meta(ge=0, le=N_ANALOG - 1)]
Fraction = Annotated[float, Meta(ge=0.01, le=1.0)]
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
    """Stop the program and the controllers of the arm; ``play_program`` starts them."""


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


def _program(simulation: Simulation, request: Any) -> None:
    boxes, state = simulation.core.control_boxes, simulation.core.state
    match request:
        case PlayProgram():
            boxes.play(request.arm, state)
        case PauseProgram():
            boxes.pause(request.arm)
        case StopProgram():
            boxes.stop(request.arm, state)


for _request in (PlayProgram, PauseProgram, StopProgram):
    handles(_request, in_tick=True)(_program)
