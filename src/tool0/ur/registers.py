"""The registers through which RTDE clients and programs exchange values."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Final, final

N_BITS: Final = 128
"""Number of boolean registers in each direction; 64 and up are for RTDE clients."""
N_NUMBERS: Final = 48
"""Number of integer and of double registers in each direction; 24 and up are for RTDE
clients."""

N_FLAGS: Final = 32
"""Number of flags of programs."""


@final
@dataclass(slots=True)
class RegisterBank:
    """The registers of one direction."""

    bits: list[bool] = field(default_factory=lambda: [False] * N_BITS)
    integers: list[int] = field(default_factory=lambda: [0] * N_NUMBERS)
    """Integer registers: 32 bits, signed."""
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
    """Callbacks that get the RTDE names of the inputs which a client has written."""

    def written(self, names: Collection[str]) -> None:
        """Notify everyone that a client has written these inputs."""
        for callback in tuple(self.when_written):
            callback(names)
