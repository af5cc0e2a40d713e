"""The fields that RTDE clients can send, and their effects.

The first connection that sets up a field reserves the field until the connection ends.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final, final

from tool0.devices.rtde_packets import LENGTHS, layout
from tool0.errors import TransportError
from tool0.protocol.control_box import SetAnalogOutput, SetIO, SetSpeedSlider
from tool0.protocol.control_box_state import AnalogDomain
from tool0.ur.registers import N_BITS, N_NUMBERS
from tool0.ur.rtde.outputs import FIRST_SINGLE_BIT, NOT_FOUND

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox
    from tool0.ur.registers import RegisterBank

IN_USE: Final = "IN_USE"
MIN_SPEED: Final = 0.01
"""Lowest position of the speed slider."""

STANDARD, CONFIGURABLE, TOOL = "standard", "configurable", "tool"
_FIRST_PIN: Final = {STANDARD: 0, CONFIGURABLE: 8, TOOL: 16}
_N_PINS: Final = {STANDARD: 8, CONFIGURABLE: 8, TOOL: 2}

_COMMANDS: Final = {
    "speed_slider_mask": "UINT32",
    "speed_slider_fraction": "DOUBLE",
    "standard_analog_output_mask": "UINT8",
    "standard_analog_output_type": "UINT8",
    "standard_analog_output_0": "DOUBLE",
    "standard_analog_output_1": "DOUBLE",
    "external_force_torque": "VECTOR6D",
    **{f"{kind}_digital_output_mask": "UINT8" for kind in _FIRST_PIN},
    **{f"{kind}_digital_output": "UINT8" for kind in _FIRST_PIN},
}
"""Types of the fields that are not registers."""

Write = Callable[["RegisterBank", Any], None]


def _write_bits(start: int) -> Write:
    def write(bank: RegisterBank, value: int) -> None:
        bank.bits[start : start + 32] = [bool(value >> k & 1) for k in range(32)]

    return write


def _write_bit(k: int) -> Write:
    return lambda bank, value: bank.bits.__setitem__(k, value)


def _write_integer(k: int) -> Write:
    return lambda bank, value: bank.integers.__setitem__(k, value)


def _write_double(k: int) -> Write:
    return lambda bank, value: bank.doubles.__setitem__(k, value)


_REGISTERS: Final[dict[str, tuple[str, Write]]] = {
    **{
        f"input_bit_registers{start}_to_{start + 31}": ("UINT32", _write_bits(start))
        for start in (0, 32)
    },
    **{
        f"input_bit_register_{k}": ("BOOL", _write_bit(k))
        for k in range(FIRST_SINGLE_BIT, N_BITS)
    },
    **{
        f"input_int_register_{k}": ("INT32", _write_integer(k))
        for k in range(N_NUMBERS)
    },
    **{
        f"input_double_register_{k}": ("DOUBLE", _write_double(k))
        for k in range(N_NUMBERS)
    },
}

INPUTS: Final[dict[str, str]] = {
    **_COMMANDS,
    **{name: kind for name, (kind, _) in _REGISTERS.items()},
}
"""The type of each field."""


@final
class InputClaims:
    """Records which connection may send which fields."""

    def __init__(self) -> None:
        self._owners: dict[str, object] = {}

    def claim(self, names: Sequence[str], owner: object) -> tuple[str, ...]:
        """Return the type of each field; claim the fields if all of them are available.

        The type of a field that is not available is ``NOT_FOUND`` or ``IN_USE``.
        """
        types = tuple(self._type(name, owner) for name in names)
        if not {NOT_FOUND, IN_USE} & set(types):
            self._owners.update(dict.fromkeys(names, owner))
        return types

    def release(self, owner: object) -> None:
        """Release the inputs that a connection claimed."""
        self._owners = {
            name: other for name, other in self._owners.items() if other is not owner
        }

    def _type(self, name: str, owner: object) -> str:
        if self._owners.get(name, owner) is not owner:
            return IN_USE
        return INPUTS.get(name, NOT_FOUND)


@final
class InputRecipe:
    """Applies the data packets of an input setup."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._written = frozenset(names)
        types = [INPUTS[name] for name in self._names]
        self._lengths = [LENGTHS[kind] for kind in types]
        self._layout = layout(types, recipe_id=False)

    def execute(self, values: bytes, box: UrControlBox) -> None:
        """Write registers and send commands to the bring-up.

        Data after the values is ignored, because ur_rtde's ``getForwardKinematics``
        sends more data than its recipe contains.

        Raises:
            TransportError: If the packet is too short for the recipe.
        """
        if len(values) < self._layout.size:
            message = f"data of {len(values)} bytes; the recipe has {self._layout.size}"
            raise TransportError(message)
        numbers = iter(self._layout.unpack_from(values))
        commands: dict[str, Any] = {}
        for name, length in zip(self._names, self._lengths, strict=True):
            value = (
                next(numbers)
                if length == 1
                else tuple(next(numbers) for _ in range(length))
            )
            if name in _REGISTERS:
                _REGISTERS[name][1](box.registers.inputs, value)
            else:
                commands[name] = value
        if commands:
            _command(box, commands)
        box.registers.written(self._written)


def _command(box: UrControlBox, values: dict[str, Any]) -> None:
    """Set the slider and the pins that the masks select; store a wrench reading."""
    if "external_force_torque" in values:
        box.rtde_sensor.read(values["external_force_torque"])
    if values.get("speed_slider_mask", 0) == 1:
        fraction = min(max(MIN_SPEED, values.get("speed_slider_fraction", 1.0)), 1.0)
        box.send(SetSpeedSlider(arm=box.arm, fraction=fraction))
    levels: dict[int, bool] = {}
    for kind, first in _FIRST_PIN.items():
        mask = values.get(f"{kind}_digital_output_mask", 0)
        bits = values.get(f"{kind}_digital_output", 0)
        for k in range(_N_PINS[kind]):
            if mask >> k & 1:
                levels[first + k] = bool(bits >> k & 1)
    if levels:
        box.send(SetIO(arm=box.arm, digital_outputs=levels))
    mask = values.get("standard_analog_output_mask", 0)
    kinds = values.get("standard_analog_output_type", 0)
    for pin in (0, 1):
        if mask >> pin & 1:
            level = values.get(f"standard_analog_output_{pin}", 0.0)
            request = SetAnalogOutput(
                arm=box.arm,
                pin=pin,
                level=min(max(0.0, level), 1.0),
                domain=AnalogDomain(kinds >> pin & 1),
            )
            box.send(request)
