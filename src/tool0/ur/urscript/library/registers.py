"""Functions for the registers that programs share with RTDE clients."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Final, TypeAlias, TypeVar

from tool0.ur.registers import N_BITS, N_FLAGS, N_NUMBERS, RegisterBank
from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import Bool, Integer, Kind, Number
from tool0.ur.urscript.values import Value
from tool0.ur.urscript_errors import ValueProblem

T = TypeVar("T", bool, int, float)


def address_kind(count: int) -> Kind:
    """Return the kind that accepts integers from 0 to ``count`` - 1."""

    def convert(value: Value) -> int:
        if type(value) is not int or not 0 <= value < count:
            raise ValueProblem(f"an integer from 0 to {count - 1} is needed")
        return value

    return Kind(f"an integer from 0 to {count - 1}", convert)


Bit: TypeAlias = Annotated[int, address_kind(N_BITS)]
Address: TypeAlias = Annotated[int, address_kind(N_NUMBERS)]
Flag: TypeAlias = Annotated[int, address_kind(N_FLAGS)]


def write_output_boolean_register(thread: Thread, address: Bit, value: Bool) -> None:
    """Write a boolean that RTDE clients can read."""
    thread.box.registers.outputs.bits[address] = value


def write_output_integer_register(
    thread: Thread, address: Address, value: Integer
) -> None:
    """Write an integer that RTDE clients can read."""
    thread.box.registers.outputs.integers[address] = value


def write_output_float_register(
    thread: Thread, address: Address, value: Number
) -> None:
    """Write a number that RTDE clients can read."""
    thread.box.registers.outputs.doubles[address] = float(value)


def set_flag(thread: Thread, n: Flag, b: Bool) -> None:
    """Set a flag, which keeps its value after the program ends."""
    thread.box.flags[n] = b


def get_flag(thread: Thread, n: Flag) -> bool:
    """Return a flag."""
    return thread.box.flags[n]


def _reader(
    name: str, bank: Callable[[Thread], RegisterBank], field: str, kind: object
) -> Function:
    def read(thread: Thread, address: int) -> Value:
        values: list[Value] = getattr(bank(thread), field)
        return values[address]

    read.__annotations__["address"] = kind
    return function(read, name)


def _inputs(thread: Thread) -> RegisterBank:
    return thread.box.registers.inputs


def _outputs(thread: Thread) -> RegisterBank:
    return thread.box.registers.outputs


FUNCTIONS: Final[tuple[Function, ...]] = (
    *(function(item) for item in (get_flag, set_flag)),
    function(write_output_boolean_register),
    function(write_output_integer_register),
    function(write_output_float_register),
    *(
        _reader(f"read_{direction}_{kind}_register", bank, field, hint)
        for direction, bank in (("input", _inputs), ("output", _outputs))
        for kind, field, hint in (
            ("boolean", "bits", Bit),
            ("integer", "integers", Address),
            ("float", "doubles", Address),
        )
    ),
)
