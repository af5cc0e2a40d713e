"""Functions for RTDE, temperatures, conveyor encoders and power.

The simulation has no conveyors, so programs set the encoder ticks.
"""

from __future__ import annotations

from typing import Annotated, Final, TypeAlias

from tool0.protocol.control_box import PowerOff
from tool0.ur.rtde.inputs import INPUTS
from tool0.ur.rtde.outputs import OUTPUTS
from tool0.ur.rtde.quantities import ROOM_TEMPERATURE, tool_accelerometer
from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import Integer, Joints, Number, Text, Vector
from tool0.ur.urscript.library.registers import address_kind
from tool0.ur.urscript.values import Value, checked_list
from tool0.ur.urscript.watchdogs import ACTIONS
from tool0.ur.urscript_errors import ValueProblem

ENCODER_RANGES: Final = (
    range(-(2**31), 2**31),
    range(2**8),
    range(2**16),
    range(2**24),
    range(2**32),
)
"""Ranges of encoder ticks; the index is URScript's number of the range."""

Joint: TypeAlias = Annotated[int, address_kind(6)]
Encoder: TypeAlias = Annotated[int, address_kind(2)]
RangeNumber: TypeAlias = Annotated[int, address_kind(len(ENCODER_RANGES))]


def rtde_set_watchdog(
    thread: Thread, variable_name: Text, min_frequency: Number, action: Text = "pause"
) -> None:
    """Pause or stop the program if an input's write rate is too low [wall Hz]."""
    if variable_name not in INPUTS:
        raise ValueProblem(f"RTDE has no input '{variable_name}'")
    if not min_frequency > 0.0:
        raise ValueProblem(f"the frequency is {min_frequency}; it is greater than 0")
    known = {item.lower(): item for item in ACTIONS}
    if action.lower() not in known:
        raise ValueProblem(f"the action is '{action}'; it is {', '.join(ACTIONS)}")
    thread.execution.watchdogs.watch(
        variable_name, 1.0 / min_frequency, known[action.lower()]
    )


def get_rtde_value(thread: Thread, key: Text) -> Value:
    """Return the value of an RTDE output: a number, a boolean or a list."""
    field = OUTPUTS.get(key)
    if field is None:
        raise ValueProblem(f"RTDE has no output '{key}'")
    value = field.read(thread.box)
    if isinstance(value, tuple | list):
        return checked_list(value)
    return bool(value) if field.type == "BOOL" else value


def get_joint_temp(j: Joint) -> float:
    """Return the temperature of a joint, which is always room temperature [°C]."""
    del j
    return ROOM_TEMPERATURE


def get_controller_temp() -> float:
    """Return the temperature of the box, which is always room temperature [°C]."""
    return ROOM_TEMPERATURE


def get_tool_temp(thread: Thread) -> float:
    """Return the temperature of the tool, which is always room temperature [°C]."""
    return thread.box.state.tool_temperature


def get_tool_accelerometer_reading(thread: Thread) -> Value:
    """Return the gravity reading of an accelerometer in the tool [m/s²]."""
    return tool_accelerometer(thread.box)


def get_base_acceleration() -> Value:
    """Return the acceleration of the base, which is always zero [m/s²]."""
    return (0.0, 0.0, 0.0)


def set_base_acceleration(a: Vector) -> None:
    """Accept only zero, because the base does not move."""
    if any(a):
        raise ValueProblem("the base does not move: [0, 0, 0] is needed")


def set_pos(q: Joints) -> None:
    """Do nothing, because the simulation determines the joint positions."""
    del q


def pause_on_error_code(code: Integer, argument: Integer = -1) -> None:
    """Ignore the setting, because warnings never pause a program."""
    del code, argument


async def powerdown(thread: Thread) -> None:
    """Switch the arm off, which also ends the program."""
    box = thread.box
    await box.call(PowerOff(arm=box.arm))
    await box.until(lambda: bool(box.stopped))


def encoder_enable_set_tick_count(
    thread: Thread, encoder_index: Encoder, range_id: RangeNumber
) -> None:
    """Enable an encoder with a range; programs set its ticks."""
    thread.box.encoders[encoder_index] = ENCODER_RANGES[range_id], 0.0


def _encoder(thread: Thread, index: int) -> tuple[range, float]:
    found = thread.box.encoders.get(index)
    if found is None:
        raise ValueProblem(
            f"encoder {index} is not set up; encoder_enable_set_tick_count does that"
        )
    return found


def encoder_set_tick_count(
    thread: Thread, encoder_index: Encoder, count: Number
) -> None:
    """Set the number of ticks of an encoder."""
    valid, _ = _encoder(thread, encoder_index)
    if not valid[0] <= count <= valid[-1]:
        raise ValueProblem(f"count is {count}; it is from {valid[0]} to {valid[-1]}")
    thread.box.encoders[encoder_index] = valid, float(count)


def encoder_get_tick_count(thread: Thread, encoder_index: Encoder) -> float:
    """Return the number of ticks of an encoder."""
    return _encoder(thread, encoder_index)[1]


def encoder_unwind_delta_tick_count(
    thread: Thread, encoder_index: Encoder, delta_tick_count: Number
) -> float:
    """Return a tick difference, corrected for a wraparound at the end of the range."""
    size = len(_encoder(thread, encoder_index)[0])
    half = size / 2.0
    return (delta_tick_count + half) % size - half


def set_baselight_off() -> None:
    """Ignore the setting, because the base has no light."""


def set_baselight_iec() -> None:
    """Ignore the setting, because the base has no light."""


def set_baselight_solid(R: Integer, G: Integer, B: Integer) -> None:
    """Ignore the setting, because the base has no light."""
    del R, G, B


def tool_wrench_limit_disable() -> None:
    """Ignore the setting, because the tool's wrench is not limited."""


FUNCTIONS: Final[tuple[Function, ...]] = (
    function(powerdown, physical=True),
    *(
        function(item)
        for item in (
            *(encoder_enable_set_tick_count, encoder_get_tick_count),
            *(encoder_set_tick_count, encoder_unwind_delta_tick_count),
            *(get_base_acceleration, get_controller_temp, get_joint_temp),
            *(get_rtde_value, get_tool_accelerometer_reading, get_tool_temp),
            *(pause_on_error_code, rtde_set_watchdog, set_base_acceleration),
            *(set_baselight_iec, set_baselight_off, set_baselight_solid, set_pos),
            tool_wrench_limit_disable,
        )
    ),
)
