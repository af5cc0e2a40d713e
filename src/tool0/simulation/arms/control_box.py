"""The control box of an arm, and its state, which requests can change.

The speed slider and a paused program change the speed factor of scaled trajectories.  A
payload changes the model of the drives.  The states of pins are only stored.  ``Arm``
implements power, stops and programs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, final

from msgspec.structs import replace

from tool0.description.model import FLANGE, RobotModel
from tool0.description.payload import Payload
from tool0.description.payload_bodies import modelled_payload
from tool0.errors import ControlError
from tool0.hardware.own_drives import OwnDrives
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.control_box_state import (
    AnalogDomain,
    AnalogPin,
    ControlBoxState,
    ProgramState,
    SafetyLimits,
)

RAMP: Final = 5.0
"""Largest rate of change of the speed scaling factor [1/s].  After a pause, UR's driver
adds 0.01 in each cycle of 2 ms (ur_robot_driver, hardware_interface.cpp)."""
REAL_RAMP: Final = (10.0, 1.0)
"""Limits on how fast the speed scaling factor of a real robot may decrease and increase
[1/s].  A real robot limits its speed immediately.  The robot receives an increase
slightly late, and the motion during the delay must remain small."""
MOST_VOLTAGE: Final = 10.0
"""Largest voltage of an analog pin [V]."""
_WIRED: Final = "the inputs of a real robot are what their wires say"
CURRENTS: Final = (0.004, 0.020)
"""Range of the current at an analog pin [A]."""


@final
class ControlBox:
    """The control box of one arm.

    Only the thread that executes the tick may use ``ControlBox``.
    """

    def __init__(
        self,
        name: str,
        flange: str,
        model: RobotModel,
        hardware: RobotHardware,
        own_drives: OwnDrives | None = None,
    ) -> None:
        self._flange, self._model, self._hardware = flange, model, hardware
        self._own_drives = own_drives
        """Drives of a real robot; None for a simulated robot.  For a real robot, the
        pins are those of the robot's control box, and the robot's reports change the
        state."""
        self.when_changed: Callable[[], None] = lambda: None
        """Callback that is called after each change of the state."""
        self.state = ControlBoxState(
            arm=name,
            prefix=flange.removesuffix(FLANGE),
            payload=modelled_payload(model, flange),
        )
        """State of the control box.  The state object is replaced when the state
        changes."""
        self.is_steady = True
        """Whether the speed scaling factor has reached its target value."""

    # ---- the tick -------------------------------------------------------------------

    def tick(self, period: float) -> None:
        """Move the speed scaling factor toward its target value for one tick.

        ``period`` is the duration of the tick [s].
        """
        now, target = self.state.speed_scaling, _target(self.state)
        if now != target:
            ramp = RAMP if self._own_drives is None else REAL_RAMP[target > now]
            most = ramp * period
            factor = min(max(target, now - most), now + most)
            self._hardware.speed_scaling[self.state.prefix] = factor
            self.change(speed_scaling=factor)

    # ---- operations -----------------------------------------------------------------

    def set_digital(self, pins: Mapping[int, bool], *, is_input: bool) -> None:
        """Set outputs, or the measured levels of inputs, at digital pins 0 … 17."""
        name = "digital_inputs" if is_input else "digital_outputs"
        values = list(getattr(self.state, name))
        for pin, value in pins.items():
            _check_pin(pin, len(values), name)
            values[pin] = value
        if self._own_drives is not None and pins:
            if is_input:
                raise ControlError(_WIRED)
            self._own_drives.set_digital_outputs(pins)
            return
        self.change(**{name: tuple(values)})

    def set_analog_output(self, pin: int, level: float, domain: AnalogDomain) -> None:
        """Set an analog output to ``level``, a fraction of its range, 0 … 1."""
        pins = list(self.state.analog_outputs)
        _check_pin(pin, len(pins), "analog_outputs")
        if self._own_drives is not None:
            is_voltage = domain is AnalogDomain.VOLTAGE
            self._own_drives.set_analog_output(pin, level, is_voltage=is_voltage)
            return
        lowest, highest = CURRENTS
        value = MOST_VOLTAGE * level
        if domain is AnalogDomain.CURRENT:
            value = lowest + (highest - lowest) * level
        pins[pin] = AnalogPin(value, domain)
        self.change(analog_outputs=tuple(pins))

    def set_analog_input(self, pin: int, value: AnalogPin, *, is_of_tool: bool) -> None:
        """Set the measured value of an analog input of the control box or tool."""
        if self._own_drives is not None:
            raise ControlError(_WIRED)
        name = "tool_analog_inputs" if is_of_tool else "analog_inputs"
        pins = list(getattr(self.state, name))
        _check_pin(pin, len(pins), name)
        pins[pin] = value
        self.change(**{name: tuple(pins)})

    def set_speed_slider(self, fraction: float) -> None:
        """Set the speed of scaled trajectories as a fraction, 0.01 … 1."""
        if self._own_drives is not None:
            self._own_drives.set_speed_slider(fraction)
            return
        self.change(speed_slider=fraction)

    def set_payload(self, payload: Payload | None) -> None:
        """Use ``payload`` at the flange; None for the payload of the description."""
        self._hardware.set_payload(self._flange, payload)
        known = payload or modelled_payload(self._model, self._flange)
        self.change(payload=known)

    def set_safety_limits(self, is_enabled: bool | None, force: float | None) -> None:
        """Configure the automatic stops of the arm; None leaves a setting unchanged."""
        old = self.state.safety_limits
        limits = SafetyLimits(
            is_enabled=old.is_enabled if is_enabled is None else is_enabled,
            force=old.force if force is None else force,
        )
        self.change(safety_limits=limits)

    def change(self, **changes: Any) -> None:
        """Replace fields of the state."""
        changed = replace(self.state, **changes)
        if changed != self.state:
            self.state = changed
            self.is_steady = changed.speed_scaling == _target(changed)
            self.when_changed()


def _target(state: ControlBoxState) -> float:
    """Return the value that the speed scaling factor approaches."""
    return 0.0 if state.program is ProgramState.PAUSED else state.speed_slider


def _check_pin(pin: int, count: int, name: str) -> None:
    if not 0 <= pin < count:
        raise ControlError(f"{name} has pins 0 … {count - 1}, got {pin}")
