"""The control boxes of a robot's arms: requests change them, and they act.

The speed slider and a paused program change the factor of scaled trajectories, and a
payload changes the model of the drives.  Pins are only stored; ``arm_modes`` has power,
stops and programs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, final

from msgspec.structs import replace

from tool0.description.model import FLANGE, RobotModel
from tool0.description.parts import find_arms
from tool0.description.payload import Payload
from tool0.errors import ControlError, did_you_mean
from tool0.hardware.payload import modelled_payload
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.control_box_state import (
    AnalogDomain,
    AnalogPin,
    ControlBoxState,
    Pose6,
    ProgramState,
    SafetyLimits,
    UrReport,
)

RAMP: Final = 5.0
"""Largest change of the speed scaling factor [1/s]: UR's driver adds 0.01 in each cycle
of 2 ms after a pause (ur_robot_driver, hardware_interface.cpp)."""
MOST_VOLTAGE: Final = 10.0
"""Of an analogue pin [V]."""
CURRENTS: Final = (0.004, 0.020)
"""Of an analogue pin [A]."""


@final
class ControlBoxes:
    """Every arm's control box.  Only the thread of the tick may use it."""

    def __init__(self, model: RobotModel, hardware: RobotHardware) -> None:
        self._model, self._hardware = model, hardware
        self._flanges = {name: arm.flange for name, arm in find_arms(model).items()}
        self.states = tuple(
            ControlBoxState(
                arm=name,
                prefix=flange.removesuffix(FLANGE),
                payload=modelled_payload(model, flange),
            )
            for name, flange in self._flanges.items()
        )
        """One for each arm: the same tuple until something changes."""
        self.is_steady = True
        """Whether no speed scaling factor is on its way to another value."""
        self.has_limits = False
        """Whether the safety limits of an arm are enabled."""

    def find(self, arm: str | None) -> ControlBoxState:
        """Return an arm's control box; the only one without a name.

        Raises:
            ControlError: If there is no such arm, or several and no name.
        """
        if arm is None and len(self.states) == 1:
            return self.states[0]
        names = [state.arm for state in self.states]
        if arm is None:
            raise ControlError(
                "'arm' is needed unless the robot has exactly one, this one has: "
                f"{', '.join(names) or 'none'}"
            )
        found = next((state for state in self.states if state.arm == arm), None)
        if found is None:
            raise ControlError(f"no arm '{arm}'{did_you_mean(arm, names)}")
        return found

    def flange(self, arm: str) -> str:
        """Return the link at the end of an arm, by the arm's name."""
        return self._flanges[arm]

    # ---- the tick -------------------------------------------------------------------

    def tick(self, period: float) -> None:
        """Move the speed scaling factors towards their values for one tick [s]."""
        for state in self.states:
            now, target = state.speed_scaling, _target(state)
            if now != target:
                most = RAMP * period
                factor = min(max(target, now - most), now + most)
                self._hardware.speed_scaling[state.prefix] = factor
                self.change(state, speed_scaling=factor)

    # ---- operations -----------------------------------------------------------------

    def set_digital(
        self, arm: str | None, pins: Mapping[int, bool], *, is_input: bool
    ) -> None:
        """Set digital outputs, or what the inputs measure, by pin 0 … 17."""
        state = self.find(arm)
        name = "digital_inputs" if is_input else "digital_outputs"
        values = list(getattr(state, name))
        for pin, value in pins.items():
            _check_pin(pin, len(values), name)
            values[pin] = value
        self.change(state, **{name: tuple(values)})

    def set_analog_output(
        self, arm: str | None, pin: int, level: float, domain: AnalogDomain
    ) -> None:
        """Set an analogue output to a ``level`` of its range, 0 … 1."""
        state = self.find(arm)
        _check_pin(pin, len(state.analog_outputs), "analog_outputs")
        lowest, highest = CURRENTS
        value = MOST_VOLTAGE * level
        if domain is AnalogDomain.CURRENT:
            value = lowest + (highest - lowest) * level
        pins = list(state.analog_outputs)
        pins[pin] = AnalogPin(value, domain)
        self.change(state, analog_outputs=tuple(pins))

    def set_analog_input(
        self, arm: str | None, pin: int, value: AnalogPin, *, is_of_tool: bool
    ) -> None:
        """Set what an analogue input of the box or of the tool measures."""
        state = self.find(arm)
        name = "tool_analog_inputs" if is_of_tool else "analog_inputs"
        pins = list(getattr(state, name))
        _check_pin(pin, len(pins), name)
        pins[pin] = value
        self.change(state, **{name: tuple(pins)})

    def set_tool_voltage(self, arm: str | None, voltage: int) -> None:
        """Supply 0, 12 or 24 V at the tool's connector."""
        self.change(self.find(arm), tool_voltage=voltage)

    def set_speed_slider(self, arm: str | None, fraction: float) -> None:
        """Slow down scaled trajectories from now on."""
        self.change(self.find(arm), speed_slider=fraction)

    def set_payload(self, arm: str | None, payload: Payload | None) -> None:
        """Take this to be at the flange; None is what the description has."""
        state = self.find(arm)
        flange = self._flanges[state.arm]
        self._hardware.set_payload(flange, payload)
        known = payload or modelled_payload(self._model, flange)
        self.change(state, payload=known)

    def set_tcp(self, arm: str | None, tcp: Pose6) -> None:
        """Store the tool centre point, in the frame of the flange."""
        self.change(self.find(arm), tcp=tcp)

    def set_safety_limits(
        self, arm: str | None, is_enabled: bool | None, force: float | None
    ) -> None:
        """Choose what stops the arm by itself; None does not change."""
        state = self.find(arm)
        old = state.safety_limits
        limits = SafetyLimits(
            is_enabled=old.is_enabled if is_enabled is None else is_enabled,
            force=old.force if force is None else force,
        )
        self.change(state, safety_limits=limits)
        self.has_limits = any(s.safety_limits.is_enabled for s in self.states)

    def report_ur(self, arm: str | None, report: UrReport) -> None:
        """Show what the interface of UR's protocols reports of itself."""
        self.change(self.find(arm), ur=report)

    def change(self, state: ControlBoxState, **changes: Any) -> ControlBoxState:
        """Replace fields of the newest state of an arm, and return it."""
        newest = self.find(state.arm)
        changed = replace(newest, **changes)
        if changed == newest:
            return newest
        self.states = tuple(changed if item is newest else item for item in self.states)
        self.is_steady = all(s.speed_scaling == _target(s) for s in self.states)
        return changed


def _target(state: ControlBoxState) -> float:
    """Return the value that the speed scaling factor approaches."""
    return 0.0 if state.program is ProgramState.PAUSED else state.speed_slider


def _check_pin(pin: int, count: int, name: str) -> None:
    if not 0 <= pin < count:
        raise ControlError(f"{name} has pins 0 … {count - 1}, got {pin}")
