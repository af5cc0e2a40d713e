"""A sample of force and torque, as a value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from tool0.description.transform import Vector3


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class WrenchReading:
    """What the tool exerts on the flange, over one step of the physics.

    In the axes of ``frame``, at its origin, less what it was when zeroed.
    """

    time: float
    """Simulated time at the end of the step [s]."""
    number: int
    """Of the sample, since the sensor was started; no reset sets it back."""
    frame: str
    """The link."""
    force: Vector3
    """Filtered [N]."""
    torque: Vector3
    """Filtered [N·m]."""
    raw_force: Vector3
    """[N]"""
    raw_torque: Vector3
    """[N·m]"""
