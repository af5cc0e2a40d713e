"""The registers that RTDE clients and programs exchange values through."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Final, final

N_BITS: Final = 128
"""Boolean registers of each direction; 64 and up are for RTDE clients."""
N_NUMBERS: Final = 48
"""Integer and double registers of each direction; 24 and up are for RTDE clients."""

N_FLAGS: Final = 32
"""Number of flags of programs."""


@final
@dataclass(slots=True)
class RegisterBank:
    """The registers of one direction."""

    bits: list[bool] = field(default_factory=lambda: [False] * N_BITS)
    integers: list[int] = field(default_factory=lambda: [0] * N_NUMBERS)
    """32 bits, signed."""
    doubles: list[float] = field(default_factory=lambda: [0.0] * N_NUMBERS)


@final
@dataclass(slots=True)
class Registers:
    """All registers of a control box."""

    inputs: RegisterBank = field(default_factory=RegisterBank)
    """Written by clients, read by programs."""
    outputs: RegisterBank = field(default_factory=RegisterBank)
    """Written by programs, read by clients."""
    when_written: set[Callable[[Collection[str]], None]] = field(default_factory=set)
    """Called after a client has written inputs, with their names in RTDE."""

    def written(self, names: Collection[str]) -> None:
        """Tell everyone which inputs a client has written."""
        for callback in tuple(self.when_written):
            callback(names)
