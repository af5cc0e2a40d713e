"""The payload of an arm: the mass that its drives assume at the flange."""

from __future__ import annotations

import math
from typing import Annotated, Final

from msgspec import Meta, Struct

from tool0.description.transform import Vector3

DENSITY: Final = 1000.0
"""Density of the sphere that defines a payload's inertia [kg/m³].  URScript's
``set_target_payload`` without an inertia assumes the same density (1 g/cm³)."""


class Payload(Struct, frozen=True):
    """Mass and center of gravity of all bodies fixed to an arm's flange."""

    mass: Annotated[float, Meta(ge=0.0, le=1000.0)]
    """Mass of the payload [kg]."""
    center_of_gravity: Vector3 = (0.0, 0.0, 0.0)
    """Center of gravity of the payload in the flange's frame [m]."""

    @property
    def inertia(self) -> float:
        """Moment of inertia about any axis through the center of gravity [kg·m²]."""
        radius: float = (3.0 * self.mass / (4.0 * math.pi * DENSITY)) ** (1.0 / 3.0)
        return 0.4 * self.mass * radius**2
