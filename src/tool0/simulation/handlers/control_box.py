"""Handlers of the requests to an arm's control box."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

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
from tool0.simulation.arms.arm import Arm
from tool0.simulation.arms.control_box import ControlBox
from tool0.simulation.handlers.table import handles
from tool0.simulation.simulation import Simulation


def _box(simulation: Simulation, request: ArmRequest[Any]) -> ControlBox:
    return simulation.core.arms.find(request.arm).box


handles(ReadIO, in_tick=True, publishes=False)(
    lambda sim, request: _box(sim, request).state
)


@handles(SetIO, in_tick=True)
def _set_io(simulation: Simulation, request: SetIO) -> None:
    box = _box(simulation, request)
    box.set_digital(request.digital_outputs, is_input=False)
    box.set_digital(request.digital_inputs, is_input=True)
    if request.tool_voltage is not None:
        box.change(tool_voltage=request.tool_voltage)


handles(SetAnalogOutput, in_tick=True)(
    lambda sim, request: _box(sim, request).set_analog_output(
        request.pin, request.level, request.domain
    )
)
handles(SetAnalogInput, in_tick=True)(
    lambda sim, request: _box(sim, request).set_analog_input(
        request.pin,
        AnalogPin(request.value, request.domain),
        is_of_tool=request.tool,
    )
)
handles(SetSpeedSlider, in_tick=True)(
    lambda sim, request: _box(sim, request).set_speed_slider(request.fraction)
)


@handles(SetPayload, in_tick=True)
def _set_payload(simulation: Simulation, request: SetPayload) -> None:
    payload = None
    if request.mass is not None:
        payload = Payload(request.mass, request.center_of_gravity)
    simulation.core.set_payload(request.arm, payload)


handles(SetTcp, in_tick=True)(
    lambda sim, request: _box(sim, request).change(tcp=request.pose)
)
handles(SetSafetyLimits, in_tick=True)(
    lambda sim, request: _box(sim, request).set_safety_limits(
        request.enabled, request.force
    )
)
handles(ReportUr, in_tick=True)(
    lambda sim, request: _box(sim, request).change(
        ur=UrReport(
            program=request.program,
            program_state=request.program_state,
            popup=request.popup,
            clients=request.clients,
            registers=request.registers,
        )
    )
)
handles(PauseProgram, in_tick=True)(
    lambda sim, request: sim.core.arms.find(request.arm).pause()
)
handles(StopProtectively, in_tick=True)(
    lambda sim, request: sim.core.arms.find(request.arm).stop_protectively(
        request.reason, sim.core.state
    )
)


handles(UnlockProtectiveStop, in_tick=True)(
    lambda sim, request: sim.core.arms.find(request.arm).unlock(
        sim.core.state, at_once=request.at_once
    )
)


def _handles_mode(kind: type[ArmRequest[None]], change: Callable[..., None]) -> None:
    """Register a change of an arm's mode as the handler of ``kind``."""
    handles(kind, in_tick=True)(
        lambda sim, request: change(sim.core.arms.find(request.arm), sim.core.state)
    )


_handles_mode(PlayProgram, Arm.play)
_handles_mode(StopProgram, Arm.stop)
_handles_mode(PowerOff, Arm.power_off)
_handles_mode(PowerOn, Arm.power_on)
_handles_mode(ReleaseBrakes, Arm.release_brakes)
_handles_mode(RestartSafety, Arm.restart_safety)
