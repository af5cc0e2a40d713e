"""Functions for Modbus signals. All times are wall time, not simulated time."""

from __future__ import annotations

from typing import Annotated, Final, TypeAlias

from tool0.errors import ControlError
from tool0.ur.modbus.client import ConnectionProblem, DeviceError
from tool0.ur.modbus.signals import (
    MAX_FREQUENCY,
    PORT,
    Signal,
    SignalSpec,
    SignalType,
    WhenStopped,
)
from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import AnyValue, Bool, Integer, Kind, Number, Text
from tool0.ur.urscript.values import Value
from tool0.ur.urscript_errors import ValueProblem

MAX_NAME: Final = 20
"""Maximum length of a signal's name [bytes]."""
MAX_COUNT: Final = 123
"""Maximum number of registers or bits of a signal."""
_MAX_DATA: Final = 250
"""Maximum size of the data in a custom command [bytes]."""


def _range_kind(last: int, first: int = 0) -> Kind:
    words = f"an integer from {first} to {last}"

    def convert(value: Value) -> int:
        if type(value) is not int or not first <= value <= last:
            raise ValueProblem(f"{words} is needed")
        return value

    return Kind(words, convert)


def _unit_address(value: Value) -> tuple[str, int]:
    """Return the host and port of an address; the default port is that of Modbus."""
    host, colon, port = value.partition(":") if isinstance(value, str) else ("", "", "")
    if not host or (colon and not (port.isdecimal() and 0 < int(port) < 1 << 16)):
        raise ValueProblem(
            'an address such as "127.0.0.1" or "127.0.0.1:1502" is needed'
        )
    return host, int(port) if port else PORT


def _name(value: Value) -> str:
    if not isinstance(value, str) or not 0 < len(value) <= MAX_NAME:
        raise ValueProblem(f"a name of 1 to {MAX_NAME} bytes is needed")
    return value


Unit: TypeAlias = Annotated[tuple[str, int], Kind("an address", _unit_address)]
SignalName: TypeAlias = Annotated[str, Kind("the name of a signal", _name)]
Byte: TypeAlias = Annotated[int, _range_kind(255)]
Register: TypeAlias = Annotated[int, _range_kind(65535)]
Count: TypeAlias = Annotated[int, _range_kind(MAX_COUNT, 1)]
Frequency: TypeAlias = Annotated[int, _range_kind(MAX_FREQUENCY, -1)]
Choice: TypeAlias = Annotated[int, _range_kind(3)]
Source: TypeAlias = Annotated[int, _range_kind(2)]


def _signal(thread: Thread, name: str) -> Signal:
    found = thread.box.modbus.find(name)
    if found is None:
        raise ValueProblem(f"there is no signal '{name}'; modbus_add_signal adds one")
    return found


async def _add(thread: Thread, name: str, spec: SignalSpec) -> None:
    """Add a signal.

    If programs must not connect to the signal's unit, no error is raised, but the
    signal is invalid from the start. Programs from PolyScope add the signals of their
    installation even if they never use them.
    """
    is_allowed = True
    try:
        thread.execution.sockets.require_allowed(spec.host)
    except ValueProblem as problem:
        thread.box.report(ControlError(f"modbus_add_signal: {problem}"))
        is_allowed = False
    try:
        await thread.box.modbus.add(name, spec, is_allowed=is_allowed)
    except ValueError as error:
        raise ValueProblem(str(error)) from None


async def modbus_add_signal(
    thread: Thread,
    IP: Unit,
    slave_number: Byte,
    signal_address: Register,
    signal_type: Integer,
    signal_name: SignalName,
    sequential_mode: Bool = False,
    register_count: Count = 1,
) -> None:
    """Start to read or write a unit's signal; requests are always sequential."""
    del sequential_mode
    if signal_type not in set(SignalType) - {SignalType.REGISTERS_READ_AND_WRITTEN}:
        raise ValueProblem(f"the type is {signal_type}; it is 0, 1, 2, 3, 15 or 16")
    spec = SignalSpec(
        host=IP[0],
        port=IP[1],
        unit=slave_number,
        kind=SignalType(signal_type),
        address=signal_address,
        count=register_count,
    )
    await _add(thread, signal_name, spec)


async def modbus_add_rw_signal(
    thread: Thread,
    IP: Unit,
    slave_number: Byte,
    read_address: Register,
    read_register_count: Count,
    write_address: Register,
    write_register_count: Count,
    signal_name: SignalName,
    sequential_mode: Bool = False,
) -> None:
    """Start to read registers of a unit; write other registers after they are set."""
    del sequential_mode
    spec = SignalSpec(
        host=IP[0],
        port=IP[1],
        unit=slave_number,
        kind=SignalType.REGISTERS_READ_AND_WRITTEN,
        address=read_address,
        count=read_register_count,
        write_address=write_address,
        write_count=write_register_count,
    )
    await _add(thread, signal_name, spec)


async def modbus_delete_signal(thread: Thread, signal_name: SignalName) -> None:
    """Remove a signal."""
    _signal(thread, signal_name)
    await thread.box.modbus.delete(signal_name)


def modbus_get_signal_status(
    thread: Thread, signal_name: SignalName, is_secondary_program: Bool = False
) -> Value:
    """Return the newest value or list of values; raise an error if it is too old."""
    del is_secondary_program
    signal = _checked(thread, signal_name)
    values: tuple[int | bool, ...] = signal.values
    if signal.spec.kind.is_digital:
        values = tuple(map(bool, values))
    return values[0] if signal.spec.count == 1 else values


def _checked(thread: Thread, name: str) -> Signal:
    """Return a signal that is valid, or that was valid within its timeout."""
    signal = _signal(thread, name)
    if signal.invalid_for <= signal.watchdog:
        return signal
    spec = signal.spec
    reason = f"no connection ({signal.connection_error})"
    if signal.device_error:
        reason = f"the unit answers with exception {signal.device_error}"
    raise ValueProblem(
        f"signal '{name}' of {spec.host}:{spec.port} has been invalid for more than "
        f"{signal.watchdog:g} s: {reason}"
    )


def _write(thread: Thread, name: str, value: Value, *, is_digital: bool) -> None:
    signal = _checked(thread, name)
    kind = signal.spec.kind
    words = "a digital output" if is_digital else "an output register"
    if kind.is_digital is not is_digital or not kind.is_output:
        raise ValueProblem(f"signal '{name}' is not {words}")
    values = value if type(value) is tuple else (value,)
    count = signal.spec.write_count or signal.spec.count
    if not 0 < len(values) <= count:
        raise ValueProblem(f"signal '{name}' has {count} values, not {len(values)}")
    numbers: list[int] = []
    for item in values:
        if is_digital and type(item) is bool:
            numbers.append(int(item))
        elif not is_digital and type(item) is int and 0 <= item <= 65535:
            numbers.append(item)
        else:
            valid = "True or False" if is_digital else "an integer from 0 to 65535"
            raise ValueProblem(f"a value of signal '{name}' is {valid}")
    signal.write(numbers)


def modbus_set_output_signal(
    thread: Thread,
    signal_name: SignalName,
    digital_value: AnyValue,
    is_secondary_program: Bool = False,
) -> None:
    """Write a digital output, or the first output of a signal with several outputs."""
    del is_secondary_program
    _write(thread, signal_name, digital_value, is_digital=True)


def modbus_set_output_register(
    thread: Thread,
    signal_name: SignalName,
    register_value: AnyValue,
    is_secondary_program: Bool = False,
) -> None:
    """Write an output register, or the first register if a signal has several."""
    del is_secondary_program
    _write(thread, signal_name, register_value, is_digital=False)


def modbus_set_signal_update_frequency(
    thread: Thread, signal_name: SignalName, update_frequency: Frequency
) -> None:
    """Set the update rate [wall Hz]; with 0 and -1, update only on request."""
    _signal(thread, signal_name).set_frequency(update_frequency)


def modbus_request_update_signal_value(thread: Thread, signal_name: SignalName) -> None:
    """Request an update of a signal."""
    _signal(thread, signal_name).update()


def modbus_set_signal_watchdog(
    thread: Thread, signal_name: SignalName, new_timeout_in_sec: Number
) -> None:
    """Set the time for which a signal may be invalid [wall s]."""
    if not 0.0 <= new_timeout_in_sec <= 300.0:
        raise ValueProblem(f"the timeout is {new_timeout_in_sec}; it is from 0 to 300")
    _signal(thread, signal_name).watchdog = new_timeout_in_sec


def modbus_set_runstate_dependent_choice(
    thread: Thread, signal_name: SignalName, runstate_choice: Choice
) -> None:
    """Set the level of a digital output for times when no program runs."""
    signal = _signal(thread, signal_name)
    is_digital_output = signal.spec.kind.is_digital and signal.spec.kind.is_output
    if runstate_choice != WhenStopped.KEPT and not is_digital_output:
        raise ValueProblem(f"signal '{signal_name}' is not a digital output")
    signal.when_stopped = WhenStopped(runstate_choice)


def modbus_set_digital_input_action(
    thread: Thread, signal_name: SignalName, action: Text
) -> None:
    """Accept only the default action."""
    _signal(thread, signal_name)
    if action != "default":
        raise ValueProblem(f'inputs have no actions but "default", not "{action}"')


def modbus_get_error(
    thread: Thread, signal_name: SignalName, error_source: Source = 0
) -> int:
    """Return the unit's exception, the connection error, or both in 16 bits each."""
    signal = _signal(thread, signal_name)
    if error_source == 1:
        return signal.device_error
    if error_source == 2:
        return signal.connection_error
    both = (signal.connection_error & 0xFFFF) << 16 | signal.device_error
    return both - (1 << 32) if both >= 1 << 31 else both


def modbus_get_time_since_signal_invalid(
    thread: Thread, signal_name: SignalName
) -> float:
    """Return the time since a signal became invalid [wall s]; 0 if it is valid."""
    return _signal(thread, signal_name).invalid_for


async def modbus_reset_connection(
    thread: Thread, connection_id: Unit, is_blocking: Bool = True
) -> None:
    """Reconnect to a unit and wait until its signals are valid."""
    modbus = thread.box.modbus
    signals = modbus.of_host(connection_id[0])
    if not signals:
        raise ValueProblem(f"there is no signal of '{connection_id[0]}'")
    for signal in signals:
        modbus.client(signal.spec.host, signal.spec.port).close()
        signal.update()
    while is_blocking and any(signal.invalid_for for signal in signals):
        await thread.box.next_update()


async def modbus_send_custom_command(
    thread: Thread,
    IP: Unit,
    slave_number: Byte,
    function_code: Annotated[int, _range_kind(127, 1)],
    data: AnyValue,
) -> None:
    """Send a request and ignore the response."""
    values = data if type(data) is tuple else ()
    if len(values) > _MAX_DATA or not all(
        type(item) is int and 0 <= item <= 255 for item in values
    ):
        raise ValueProblem(f"data is a list of up to {_MAX_DATA} bytes")
    thread.execution.sockets.require_allowed(IP[0])
    content = bytes(item for item in values if isinstance(item, int))
    client = thread.box.modbus.client(*IP)
    try:
        await client.request(slave_number, function_code, content)
    except DeviceError as error:
        raise ValueProblem(f"the unit answers with exception {error.code}") from None
    except ConnectionProblem as problem:
        raise ValueProblem(f"no response ({problem.code})") from None


FUNCTIONS: Final[tuple[Function, ...]] = tuple(
    function(item)
    for item in (
        *(modbus_add_rw_signal, modbus_add_signal, modbus_delete_signal),
        *(modbus_get_error, modbus_get_signal_status, modbus_reset_connection),
        *(modbus_get_time_since_signal_invalid, modbus_request_update_signal_value),
        *(modbus_send_custom_command, modbus_set_digital_input_action),
        *(modbus_set_output_register, modbus_set_output_signal),
        *(modbus_set_runstate_dependent_choice, modbus_set_signal_update_frequency),
        modbus_set_signal_watchdog,
    )
)
