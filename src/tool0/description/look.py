"""Lighting of a robot and its scene in images."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, final

from tool0.description.transform import Vector3
from tool0.errors import ConfigError

LAMP: Final[Vector3] = (-0.4, -1.0, 4.0)
"""Position of the lamp in the robot's root [m]."""
BRIGHTEST: Final = 3.0
"""Largest brightness, at which the whole image is white."""
LIT: Final[Vector3] = (0.2, 0.0, 0.0)
"""Point at which the lamp is directed, in the robot's root [m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """Lighting of images: a lamp that casts shadows, and the overall brightness."""

    lamp: Vector3 = LAMP
    """Position of the lamp in the robot's root [m].  The lamp illuminates the
    workspace."""
    brightness: float = 1.0
    """Overall brightness relative to the default."""

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, self.lamp)) or self.lamp[2] < 0.5:
            raise ConfigError(
                "the lamp must be 0.5 m or more above the robot's root, got "
                f"{self.lamp}"
            )
        if not 0.0 < self.brightness <= BRIGHTEST:
            raise ConfigError(
                f"the brightness must be above 0, up to {BRIGHTEST:g}, got "
                f"{self.brightness}"
            )
