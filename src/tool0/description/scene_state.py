"""Values that describe objects, contacts and forces at one instant."""

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
    """Position of the object's origin [m]."""
    quat_wxyz: tuple[float, float, float, float]
    """Orientation of the object as a unit quaternion (w, x, y, z)."""
    linear: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Linear velocity of the object's origin [m/s]."""
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Angular velocity of the object [rad/s]."""


@final
@dataclass(frozen=True, slots=True)
class Contact:
    """Resultant of all contact points between two links or objects.

    Each link and object has a separate name, even a link that is fixed to another link.
    The engine's ground plane is called ``ground``.  Vectors are in the axes of the
    robot's root.
    """

    first: str
    """Name of the first link or object."""
    second: str
    """Name of the link or object that ``first`` touches."""
    point: tuple[float, float, float]
    """Mean of the contact points, weighted by their normal forces, in the root [m]."""
    force: tuple[float, float, float]
    """Force that ``first`` exerts on ``second`` [N]."""
    torque: tuple[float, float, float]
    """Torque that ``first`` exerts on ``second``, about ``point`` [N·m]."""


Wrench = tuple[float, float, float, float, float, float]
"""Force (x, y, z) [N] and torque (x, y, z) [N·m]."""


def contacts_text(contacts: Sequence[tuple[str, str]]) -> str:
    """Return pairs of names as text for messages."""
    return ", ".join(f"'{link}' touches '{other}'" for link, other in contacts)
