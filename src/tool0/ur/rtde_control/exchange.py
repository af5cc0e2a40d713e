"""The registers through which ur_rtde sends commands and gets their results."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Final, final

from tool0.errors import ControlError
from tool0.protocol.state import Six

if TYPE_CHECKING:
    from tool0.ur.registers import Registers

COMMAND: Final = 0
"""Integer input: the command."""
STATE: Final = 0
"""Integer output: what became of it."""
RESULT: Final = 1
"""Integer output: the result of queries that have one number."""
PROGRESS: Final = 2
"""Integer output: of asynchronous motions."""

_LOWER: Final = 24
_UPPER: Final = 36
"""A matrix has the first registers, and those from there on."""
_COUNTS: Final = 128
"""Counters of the progress have seven bits."""
_MAX_PROGRESS: Final = 0x7FFF
_RUNNING: Final = 1 << 15


class State(IntEnum):
    """The state of the client's command."""

    READY = 1
    DONE = 2


@final
class Exchange:
    """The registers from ``offset`` on."""

    def __init__(self, registers: Registers, offset: int) -> None:
        self._inputs, self._outputs = registers.inputs, registers.outputs
        self._offset = offset
        self.command_name = f"input_int_register_{offset + COMMAND}"
        """Name of the register with the command, in RTDE."""
        self.written: Collection[str] = ()
        """The inputs in the packet with the last command, by the names of RTDE."""
        self._writes = 0
        self._operations = 0

    @property
    def command(self) -> int:
        """The command that the client wants; 0 for none."""
        return self.integer(COMMAND)

    def tell(self, state: State) -> None:
        """Tell the client about its command."""
        self._outputs.integers[self._offset + STATE] = state

    # ---- arguments ------------------------------------------------------------------

    def integer(self, register: int) -> int:
        """Return an integer argument."""
        return self._inputs.integers[self._offset + register]

    def number(self, register: int) -> float:
        """Return an argument."""
        return self._inputs.doubles[self._offset + register]

    def has_number(self, register: int) -> bool:
        """Return whether the client sent this argument with its command."""
        return f"input_double_register_{self._offset + register}" in self.written

    def six(self, register: int) -> Six:
        """Return six arguments: joint positions, a pose, a wrench."""
        first = self._offset + register
        a, b, c, d, e, f = self._inputs.doubles[first : first + 6]
        return (a, b, c, d, e, f)

    def three(self, register: int) -> tuple[float, float, float]:
        """Return three arguments: a vector."""
        first = self._offset + register
        a, b, c = self._inputs.doubles[first : first + 3]
        return (a, b, c)

    # ---- results --------------------------------------------------------------------

    def answer(self, values: Sequence[float]) -> None:
        """Set the numbers that a query returns."""
        first = self._offset
        self._outputs.doubles[first : first + len(values)] = values

    def answer_matrix(self, rows: Sequence[Six]) -> None:
        """Set the columns of a matrix, shape (6, 6), which a query returns.

        Raises:
            ControlError: If the client uses the upper registers: it needs both ranges.
        """
        if self._offset:
            raise ControlError(
                "matrices need the lower range of RTDE's registers, too; connect "
                "without FLAG_UPPER_RANGE_REGISTERS"
            )
        values = [value for column in zip(*rows, strict=True) for value in column]
        doubles = self._outputs.doubles
        doubles[:_LOWER], doubles[_UPPER:] = values[:_LOWER], values[_LOWER:]

    def answer_integer(self, value: int) -> None:
        """Set the integer that a query returns, or 0 and 1 for false and true."""
        self._outputs.integers[self._offset + RESULT] = int(value)

    def show_progress(self, progress: int | None) -> None:
        """Show how far an asynchronous motion is; None when it has ended, 0 at first.

        Bits 0 … 14 are the progress, bit 15 is set while the motion runs; bits 16 … 22
        count what is written here, bits 24 … 30 motions.
        """
        self._writes = (self._writes + 1) % _COUNTS
        if progress == 0:
            self._operations = (self._operations + 1) % _COUNTS
        value = self._writes << 16 | self._operations << 24
        if progress is not None:
            value |= min(progress, _MAX_PROGRESS) | _RUNNING
        self._outputs.integers[self._offset + PROGRESS] = value
