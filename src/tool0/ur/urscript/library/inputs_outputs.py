"""Functions for digital and analog pins of the control box and the tool."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal, TypeAlias, cast

from tool0.protocol.control_box import SetAnalogOutput, SetIO
from tool0.protocol.control_box_state import AnalogDomain, AnalogPin
from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import Bool, Integer, Number
from tool0.ur.urscript.library.registers import address_kind
from tool0.ur.urscript.values import Value
from tool0.ur.urscript_errors import ValueProblem

CONFIGURABLE: Final = 8
"""Number of the first configurable pin in the numbering of all digital pins."""
TOOL: Final = 16
_CURRENT_RANGE: Final = (0.004, 0.020)
"""Range of an analog current [A]."""
_VOLTAGE_RANGE: Final = (0.0, 10.0)
"""Range of an analog voltage [V]."""

Standard: TypeAlias = Annotated[int, address_kind(8)]
OfTool: TypeAlias = Annotated[int, address_kind(2)]
All: TypeAlias = Annotated[int, address_kind(18)]
Analog: TypeAlias = Annotated[int, address_kind(2)]
AnyAnalog: TypeAlias = Annotated[int, address_kind(4)]


async def _set(thread: Thread, pin: int, level: bool) -> None:
    request = SetIO(arm=thread.box.arm, digital_outputs={pin: level})
    await thread.box.call(request)
    box = thread.box
    await thread.until_shown(lambda: box.state.digital_outputs[pin] == level)


async def set_standard_digital_out(thread: Thread, n: Standard, b: Bool) -> None:
    """Set a standard digital output."""
    await _set(thread, n, b)


async def set_configurable_digital_out(thread: Thread, n: Standard, b: Bool) -> None:
    """Set a configurable digital output."""
    await _set(thread, CONFIGURABLE + n, b)


async def set_tool_digital_out(thread: Thread, n: OfTool, b: Bool) -> None:
    """Set a digital output of the tool."""
    await _set(thread, TOOL + n, b)


async def set_digital_out(thread: Thread, n: All, b: Bool) -> None:
    """Set a digital output: 0 … 7 standard, 8 … 15 configurable, 16 and 17 tool."""
    await _set(thread, n, b)


async def set_analog_out(thread: Thread, n: Analog, f: Number) -> None:
    """Set an analog output to a fraction of its range."""
    if not 0.0 <= f <= 1.0:
        raise ValueProblem(f"the level is {f}; it is a fraction from 0 to 1")
    domain = thread.box.state.analog_outputs[n].domain
    request = SetAnalogOutput(arm=thread.box.arm, pin=n, level=f, domain=domain)
    await thread.box.call(request)


async def set_analog_outputdomain(thread: Thread, port: Analog, domain: Analog) -> None:
    """Set an analog output to current (0) or voltage (1)."""
    pin = thread.box.state.analog_outputs[port]
    request = SetAnalogOutput(
        arm=thread.box.arm,
        pin=port,
        level=_fraction(pin),
        domain=AnalogDomain(domain),
    )
    await thread.box.call(request)


async def set_tool_voltage(thread: Thread, voltage: Integer) -> None:
    """Set the voltage at the tool's connector [V]."""
    if voltage not in {0, 12, 24}:
        raise ValueProblem(f"the voltage is {voltage}; it can be 0, 12 or 24")
    value = cast("Literal[0, 12, 24]", voltage)
    await thread.box.call(SetIO(arm=thread.box.arm, tool_voltage=value))


def get_analog_in(thread: Thread, n: AnyAnalog) -> float:
    """Return an analog input [V or A]: 0 or 1 of the box, or 2 or 3 of the tool."""
    state = thread.box.state
    return (state.analog_inputs + state.tool_analog_inputs)[n].value


def get_standard_analog_in(thread: Thread, n: Analog) -> float:
    """Return an analog input of the control box [V or A]."""
    return thread.box.state.analog_inputs[n].value


def get_tool_analog_in(thread: Thread, n: Analog) -> float:
    """Return an analog input of the tool [V or A]."""
    return thread.box.state.tool_analog_inputs[n].value


def get_standard_analog_out(thread: Thread, n: Analog) -> float:
    """Return an analog output as a fraction of its range."""
    return _fraction(thread.box.state.analog_outputs[n])


def get_tool_current(thread: Thread) -> float:
    """Return the current that the tool draws [A]."""
    return thread.box.state.tool_current


def _fraction(pin: AnalogPin) -> float:
    is_current = pin.domain is AnalogDomain.CURRENT
    low, high = _CURRENT_RANGE if is_current else _VOLTAGE_RANGE
    return min(max((pin.value - low) / (high - low), 0.0), 1.0)


# Any: the annotation of the pin number.
def _reader(name: str, field: str, first: int, kind: Any) -> Function:
    def read(thread: Thread, n: int) -> Value:
        levels: tuple[bool, ...] = getattr(thread.box.state, field)
        return levels[first + n]

    read.__annotations__["n"] = kind
    return function(read, name)


FUNCTIONS: Final[tuple[Function, ...]] = (
    *(function(item) for item in (get_analog_in, get_standard_analog_in)),
    *(function(item) for item in (get_standard_analog_out, get_tool_analog_in)),
    *(function(item) for item in (get_tool_current, set_analog_out)),
    *(function(item) for item in (set_analog_outputdomain, set_digital_out)),
    *(function(item) for item in (set_configurable_digital_out, set_tool_voltage)),
    *(function(item) for item in (set_standard_digital_out, set_tool_digital_out)),
    function(set_analog_out, "set_standard_analog_out"),
    function(get_standard_analog_out, "get_analog_out"),
    *(
        _reader(f"get_{group}digital_{direction}", field, first, kind)
        for direction, field in (("in", "digital_inputs"), ("out", "digital_outputs"))
        for group, first, kind in (
            ("", 0, All),
            ("standard_", 0, Standard),
            ("configurable_", CONFIGURABLE, Standard),
            ("tool_", TOOL, OfTool),
        )
    ),
)
