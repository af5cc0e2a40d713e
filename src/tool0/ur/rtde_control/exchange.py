"""The registers through which ur_rtde sends commands and receives results."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Final, final

from tool0.errors import ControlError
from tool0.protocol.state import Six

if TYPE_CHECKING:
    from tool0.ur.registers import Registers

COMMAND: Final = 0
"""Integer input register with the command."""
STATE: Final = 0
"""Integer output register with the state of the command."""
RESULT: Final = 1
"""Integer output register with the result of a query that returns one number."""
PROGRESS: Final = 2
"""Integer output register with the progress of asynchronous motions."""

_LOWER: Final = 24
_UPPER: Final = 36
"""First register of a matrix's last 12 values; the first 24 values start at register
0."""
_COUNTS: Final = 128
"""Number of values of a progress counter, which has seven bits."""
_MAX_PROGRESS: Final = 0x7FFF
_RUNNING: Final = 1 << 15


class State(IntEnum):
    """State of the client's command."""

    READY = 1
    DONE = 2


@final
class Exchange:
    """The registers starting at ``offset`` that transfer commands and results."""

    def __init__(self, registers: Registers, offset: int) -> None:
        self._inputs, self._outputs = registers.inputs, registers.outputs
        self._offset = offset
        self.command_name = f"input_int_register_{offset + COMMAND}"
        """RTDE's name for the register with the command."""
        self.written: Collection[str] = ()
        """RTDE's names for the inputs in the packet with the last command."""
        self._writes = 0
        self._operations = 0

    @property
    def command(self) -> int:
        """Number of the client's command; 0 if there is none."""
        return self.integer(COMMAND)

    def tell(self, state: State) -> None:
        """Report the state of the command to the client."""
        self._outputs.integers[self._offset + STATE] = state

    # ---- arguments ------------------------------------------------------------------

    def integer(self, register: int) -> int:
        """Return an argument that is an integer."""
        return self._inputs.integers[self._offset + register]

    def number(self, register: int) -> float:
        """Return an argument that is a floating-point number."""
        return self._inputs.doubles[self._offset + register]

    def has_number(self, register: int) -> bool:
        """Return whether the client sent this argument with the command."""
        return f"input_double_register_{self._offset + register}" in self.written

    def six(self, register: int) -> Six:
        """Return six arguments, such as joint positions, a pose or a wrench."""
        first = self._offset + register
        a, b, c, d, e, f = self._inputs.doubles[first : first + 6]
        return (a, b, c, d, e, f)

    def three(self, register: int) -> tuple[float, float, float]:
        """Return three arguments that form a vector."""
        first = self._offset + register
        a, b, c = self._inputs.doubles[first : first + 3]
        return (a, b, c)

    # ---- results --------------------------------------------------------------------

    def answer(self, values: Sequence[float]) -> None:
        """Set the result of a query that returns numbers."""
        first = self._offset
        self._outputs.doubles[first : first + len(values)] = values

    def answer_matrix(self, rows: Sequence[Six]) -> None:
        """Set the result of a query that returns a (6, 6) matrix, column by column.

        Raises:
            ControlError: If the client uses the upper registers, because a matrix needs
                both register ranges.
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
        """Set the result of a query that returns an integer or a boolean (0 or 1)."""
        self._outputs.integers[self._offset + RESULT] = int(value)

    def show_progress(self, progress: int | None) -> None:
        """Show the progress of an asynchronous motion: first 0, and None at the end.

        Bits 0 … 14 contain the progress. Bit 15 is set while the motion is active. Bits
        16 … 22 count the values that this method writes. Bits 24 … 30 count the
        motions.
        """
        self._writes = (self._writes + 1) % _COUNTS
        if progress == 0:
            self._operations = (self._operations + 1) % _COUNTS
        value = self._writes << 16 | self._operations << 24
        if progress is not None:
            value |= min(progress, _MAX_PROGRESS) | _RUNNING
        self._outputs.integers[self._offset + PROGRESS] = value
