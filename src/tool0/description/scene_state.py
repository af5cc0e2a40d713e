"""Objects, contacts and forces at one instant, as values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True, slots=True)
class ObjectState:
    """Pose and velocity of a scene object, in the robot's root."""

    name: str
    """Name of the object."""
    position: tuple[float, float, float]
    """Position of its origin [m]."""
    quat_wxyz: tuple[float, float, float, float]
    """Orientation, a unit quaternion."""
    linear: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Velocity of its origin [m/s]."""
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Angular velocity [rad/s]."""


@final
@dataclass(frozen=True, slots=True)
class Contact:
    """The resultant of all contact points between two links or objects.

    Links and objects have their own names, also links that are fixed to others; the
    engine's own ground is ``ground``.  Vectors are in the axes of the robot's root.
    """

    first: str
    """A link or an object."""
    second: str
    """The touched body."""
    point: tuple[float, float, float]
    """Mean of the contact points, weighted by their normal forces, in the root [m]."""
    force: tuple[float, float, float]
    """Force that ``first`` exerts on ``second`` [N]."""
    torque: tuple[float, float, float]
    """Torque that ``first`` exerts on ``second``, about ``point`` [N·m]."""


Wrench = tuple[float, float, float, float, float, float]
"""Force [N] and torque [N·m]."""


def contacts_text(contacts: Sequence[tuple[str, str]]) -> str:
    """Return pairs of names as text."""
    return ", ".join(f"'{link}' touches '{other}'" for link, other in contacts)
