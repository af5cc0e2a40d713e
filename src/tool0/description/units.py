"""Numbers with units in user input, and detection of values in a wrong unit.

Every file and option of tool0 accepts units, such as ``40mm``, ``90deg`` and
``250mm/s``, with or without a space before the unit.  ROS's notations for angles are
also accepted: ``deg(90)``, ``rad(1.57)`` and, in YAML, ``!degrees 90`` and
``!radians 1.57``.  All internal values are in SI units.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Final, final

from tool0.errors import ConfigError

_NUMBER = re.compile(
    r"([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*([^\W\d_]*(?:/s)?)", re.I
)
_ROS_ANGLE = re.compile(r"(deg|rad)\(([^)]*)\)")
"""Pattern of rosparam's angles, such as ``deg(90)`` and ``rad(pi/2)``.  Only plain
numbers in the parentheses are supported."""
ANGLE_TAGS: Final = {"!degrees": "deg", "!radians": "rad"}
"""ROS's YAML tags, and the unit that each tag denotes."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """A physical quantity, and the units in which its values can be written."""

    name: str
    units: Mapping[str, float]
    """The SI unit and another common unit, each with the factor that converts values to
    the SI unit."""
    suspect: float
    """Magnitude at and above which a value is probably in the other unit [SI unit]."""

    def suggestion(self, value: float, fits: Callable[[float], bool]) -> str:
        """Return a hint such as ``; did you mean 90deg = 1.571 rad?``, or ``""``.

        Args:
            value: A rejected value, in the SI unit.
            fits: Function that returns whether another value would be accepted.
        """
        si, other = self.units
        meant = value * self.units[other]
        if not self.suspect <= abs(value) < math.inf or not fits(meant):
            return ""
        return f"; did you mean {value:g}{other} = {meant:.4g} {si}?"

    def require_plausible(self, value: float, what: str) -> None:
        """Raise ConfigError if ``value`` is too large to be in the SI unit.

        Args:
            value: The value to check.  Values other than finite floats are ignored.
            what: Name of the value, for the error message.
        """
        if self.suspect <= abs(value) <= sys.float_info.max:
            hint = self.suggestion(value, lambda meant: True)
            si = next(iter(self.units))
            raise ConfigError(
                f"{what}: {value:g} {si} is no plausible {self.name}{hint}"
            )


LENGTH: Final = Quantity("length", {"m": 1.0, "mm": 1e-3}, 1.0)
ANGLE: Final = Quantity("angle", {"rad": 1.0, "deg": math.radians(1.0)}, 10.0)
SPEED: Final = Quantity("speed", {"m/s": 1.0, "mm/s": 1e-3}, 10.0)
"""Speed of a tool.  No arm reaches 10 m/s."""

Metres = Annotated[float, LENGTH]
Radians = Annotated[float, ANGLE]
MetresPerSecond = Annotated[float, SPEED]

FAR: Final = 100.0
"""Distance from the nearest link [m] at and above which an object's position is assumed
to be in mm."""
LARGEST_MOVABLE: Final = 5.0
"""Edge length [m] at and above which a movable body's size is assumed to be in mm."""
LARGEST_FIXED: Final = 20.0
"""Edge length [m] at and above which a fixed body's size is assumed to be in mm.  This
value is larger than that for movable bodies, since the fixed body may be the ground."""


def read_number(text: str, *quantities: Quantity) -> tuple[float, Quantity | None]:
    """Return the number in ``text``, in the SI unit, and the quantity of its unit.

    Args:
        text: A number with or without a unit.
        quantities: Quantities to which the unit can belong.

    Raises:
        ConfigError: If the text is not a finite number or has another unit.  The error
            is also raised if the number has no unit and is implausible, such as an
            angle of several turns.
    """
    ros = _ROS_ANGLE.fullmatch(text.strip())
    match = _NUMBER.fullmatch(ros[2].strip() + ros[1] if ros else text.strip())
    value = float(match[1]) if match else math.nan
    if match is None or not math.isfinite(value):
        raise ConfigError(f"'{text}': need a finite number{_with_unit(quantities)}")
    if not match[2]:
        if quantities in ((ANGLE,), (SPEED,)):
            quantities[0].require_plausible(value, f"'{text}'")
        return value, None
    for quantity in quantities:
        if match[2] in quantity.units:
            return value * quantity.units[match[2]], quantity
    problem = f"'{match[2]}' is not a unit here"
    raise ConfigError(f"'{text}': {problem}; need a number{_with_unit(quantities)}")


def is_ros_angle(text: str) -> bool:
    """Return whether a text is an angle in rosparam's notation."""
    return _ROS_ANGLE.fullmatch(text) is not None


def within_a_turn(angle: float) -> float:
    """Return ``angle`` [rad], reduced to one turn if it is implausibly large.

    ROS accepts robot files with such angles.
    """
    return angle if abs(angle) < ANGLE.suspect else math.remainder(angle, math.tau)


def require_plausible_angles(angles: object, what: str) -> None:
    """Raise ConfigError if an angle is so large that it must be in degrees."""
    listed = angles.tolist() if hasattr(angles, "tolist") else angles  # NumPy arrays
    for angle in listed if isinstance(listed, Sequence) else ():
        if isinstance(angle, int | float):
            ANGLE.require_plausible(angle, what)


def require_plausible_size(
    edges: Sequence[float], what: str, *, is_fixed: bool
) -> None:
    """Raise ConfigError if a body is so large that its size must be in mm.

    Args:
        edges: Lengths of the body along each axis [m].
        what: Description of the body, for the error message.
        is_fixed: Whether the body cannot move.
    """
    largest = LARGEST_FIXED if is_fixed else LARGEST_MOVABLE
    if largest <= min(edges) < math.inf:
        size = " x ".join(f"{edge:g}" for edge in edges)
        hint = LENGTH.suggestion(min(edges), lambda meant: True)
        raise ConfigError(f"the size of {what} is {size} m{hint}")


def _with_unit(quantities: tuple[Quantity, ...]) -> str:
    units = [unit for quantity in quantities for unit in quantity.units]
    return f", alone or with {', '.join(units)}" if units else ""
