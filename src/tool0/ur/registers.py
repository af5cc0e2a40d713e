"""The registers through which RTDE clients and programs exchange values."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Final, final

N_BITS: Final = 128
"""Number of boolean registers per direction; 64 and higher are for RTDE clients."""
N_NUMBERS: Final = 48
"""Number of integer registers and of double registers per direction; 24 and higher are
for RTDE clients."""

N_FLAGS: Final = 32
"""Number of flags that programs can set."""


@final
@dataclass(slots=True)
class RegisterBank:
    """The registers of one direction."""

    bits: list[bool] = field(default_factory=lambda: [False] * N_BITS)
    integers: list[int] = field(default_factory=lambda: [0] * N_NUMBERS)
    """Values of the integer registers: 32 bits, signed."""
    doubles: list[float] = field(default_factory=lambda: [0.0] * N_NUMBERS)


@final
@dataclass(slots=True)
class Registers:
    """All registers of a control box."""

    inputs: RegisterBank = field(default_factory=RegisterBank)
    """Registers that clients write and programs read."""
    outputs: RegisterBank = field(default_factory=RegisterBank)
    """Registers that programs write and clients read."""
    when_written: set[Callable[[Collection[str]], None]] = field(default_factory=set)
    """Callbacks that receive the RTDE names of the inputs that a client has written."""

    def written(self, names: Collection[str]) -> None:
        """Call all callbacks with the names of the inputs that a client has written."""
        for callback in tuple(self.when_written):
            callback(names)
