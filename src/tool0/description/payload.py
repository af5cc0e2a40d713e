"""The payload of an arm: the mass that its drives assume at the flange."""

from __future__ import annotations

import math
from typing import Annotated, Final

from msgspec import Meta, Struct

from tool0.description.transform import Vector3

DENSITY: Final = 1000.0
"""Density of the sphere that defines a payload's inertia [kg/m³]: 1 g/cm³, as in
URScript's ``set_target_payload`` without an inertia."""


class Payload(Struct, frozen=True):
    """Mass and centre of gravity of everything fixed to an arm's flange."""

    mass: Annotated[float, Meta(ge=0.0, le=1000.0)]
    """Mass of the payload [kg]."""
    center_of_gravity: Vector3 = (0.0, 0.0, 0.0)
    """Center of gravity in the flange's frame [m]."""

    @property
    def inertia(self) -> float:
        """Moment of inertia about any axis through the centre of gravity [kg·m²]."""
        radius: float = (3.0 * self.mass / (4.0 * math.pi * DENSITY)) ** (1.0 / 3.0)
        return 0.4 * self.mass * radius**2
