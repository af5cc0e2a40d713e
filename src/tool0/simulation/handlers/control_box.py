"""Handlers of the requests to the control box of an arm."""

from __future__ import annotations

from collections.abc import Callable

from tool0.description.payload import Payload
from tool0.protocol.control_box import (
    PauseProgram,
    PlayProgram,
    PowerOff,
    PowerOn,
    ReadIO,
    ReleaseBrakes,
    ReportUr,
    RestartSafety,
    SetAnalogInput,
    SetAnalogOutput,
    SetIO,
    SetPayload,
    SetSafetyLimits,
    SetSpeedSlider,
    SetTcp,
    StopProgram,
    StopProtectively,
    UnlockProtectiveStop,
)
from tool0.protocol.control_box_state import AnalogPin, UrReport
from tool0.protocol.request import ArmRequest
from tool0.simulation.arm_modes import ArmModes
from tool0.simulation.handlers.table import handles
from tool0.simulation.simulation import Simulation

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
handles(StopProtectively, in_tick=True)(
    lambda sim, request: sim.core.arm_modes.stop_protectively(
        request.arm, request.reason, sim.core.state
    )
)


def _handles_mode(kind: type[ArmRequest[None]], change: Callable[..., None]) -> None:
    """Register a change of an arm's mode as the handler of ``kind``."""
    handles(kind, in_tick=True)(
        lambda sim, request: change(sim.core.arm_modes, request.arm, sim.core.state)
    )


_handles_mode(PlayProgram, ArmModes.play)
_handles_mode(StopProgram, ArmModes.stop)
_handles_mode(PowerOff, ArmModes.power_off)
_handles_mode(PowerOn, ArmModes.power_on)
_handles_mode(ReleaseBrakes, ArmModes.release_brakes)
_handles_mode(UnlockProtectiveStop, ArmModes.unlock)
_handles_mode(RestartSafety, ArmModes.restart_safety)
