"""Lengths and angles as people type them: ``40mm``, ``90deg``.  Inside, all is SI."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Final, final

from tool0.errors import ConfigError

_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*([^\W\d_]*)", re.I)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """A physical quantity, with the units in which it can be typed."""

    name: str
    units: Mapping[str, float]
    """The SI unit and the other usual one, with their sizes."""
    suspect: float
    """A value from this on is probably in the other unit."""

    def suggestion(self, value: float, fits: Callable[[float], bool]) -> str:
        """Return ``; did you mean 90deg = 1.571 rad?`` if that fits, or nothing.

        Args:
            value: A refused value, in SI.
            fits: Whether another value would be accepted.
        """
        si, other = self.units
        meant = value * self.units[other]
        if not self.suspect <= abs(value) < math.inf or not fits(meant):
            return ""
        return f"; did you mean {value:g}{other} = {meant:.4g} {si}?"


LENGTH: Final = Quantity("length", {"m": 1.0, "mm": 1e-3}, 1.0)
ANGLE: Final = Quantity("angle", {"rad": 1.0, "deg": math.radians(1.0)}, 10.0)

Metres = Annotated[float, LENGTH]
Radians = Annotated[float, ANGLE]


def read_number(text: str, *quantities: Quantity) -> tuple[float, Quantity | None]:
    """Return a typed number in SI units, and what its unit measures.

    Args:
        text: A number, with a unit or without one.
        quantities: What it may measure.

    Raises:
        ConfigError: If it is no finite number, if it has another unit, or if it is an
            angle of several turns without a unit.
    """
    match = _NUMBER.fullmatch(text.strip())
    value = float(match[1]) if match else math.nan
    if match is None or not math.isfinite(value):
        raise ConfigError(f"'{text}': need a finite number{_with_unit(quantities)}")
    if not match[2]:
        if quantities == (ANGLE,) and abs(value) >= ANGLE.suspect:
            hint = ANGLE.suggestion(value, lambda meant: True)
            raise ConfigError(f"'{text}': an angle of {value:g} rad{hint}")
        return value, None
    for quantity in quantities:
        if match[2] in quantity.units:
            return value * quantity.units[match[2]], quantity
    problem = f"'{match[2]}' is not a unit here"
    raise ConfigError(f"'{text}': {problem}; need a number{_with_unit(quantities)}")


def _with_unit(quantities: tuple[Quantity, ...]) -> str:
    units = [unit for quantity in quantities for unit in quantity.units]
    return f", alone or with {', '.join(units)}" if units else ""
