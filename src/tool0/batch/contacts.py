"""The contacts of the copies of a batch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from tool0.batch.arguments import Indices
from tool0.description.model import RobotModel
from tool0.description.scene import GROUND
from tool0.description.transform_arrays import Array
from tool0.errors import ControlError, did_you_mean

if TYPE_CHECKING:
    from tool0.engines.mujoco.contact_arrays import ContactArrays

Bodies = str | Sequence[str]
"""Name of a link or an object, ``ground``, or several of these names."""


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Contacts:
    """Contacts of all copies in the last step, as m rows sorted by copy.

    Each row is a ``Contact`` of one copy: the resultant of all contact points between
    two links or objects.  Vectors are in the axes of the root.
    """

    copy: NDArray[np.intp]
    """Number of the copy, shape (m,)."""
    first: NDArray[np.str_]
    """Name of a link, an object or ``ground``, shape (m,)."""
    second: NDArray[np.str_]
    """Name of the touched link or object, shape (m,)."""
    point: Array
    """Mean of the contact points in the root frame, weighted by their normal forces
    [m], shape (m, 3)."""
    normal: Array
    """Mean of the contact normals, which point from ``first`` to ``second``, weighted
    by the normal forces, shape (m, 3).  The length of the normal is 1, or 0 where one
    body is clamped between two sides of the other body."""
    distance: Array
    """Smallest distance between the surfaces [m], shape (m,); negative if they
    overlap."""
    force: Array
    """Force that ``first`` exerts on ``second`` [N], shape (m, 3)."""
    torque: Array
    """Torque that ``first`` exerts on ``second``, about ``point`` [N·m], (m, 3)."""

    def __post_init__(self) -> None:
        for each in fields(self):
            getattr(self, each.name).flags.writeable = False

    def __len__(self) -> int:
        return len(self.copy)


def contacts_of(found: ContactArrays, rows: Indices) -> Contacts:
    """Return the contacts of the copies in ``rows``."""
    chosen = np.isin(found.world, rows)
    return Contacts(
        copy=found.world[chosen],
        first=found.first[chosen],
        second=found.second[chosen],
        point=found.point[chosen],
        normal=found.normal[chosen],
        distance=found.distance[chosen],
        force=found.force[chosen],
        torque=found.torque[chosen],
    )


def checked_bodies(
    what: str, given: Bodies | None, model: RobotModel, objects: Sequence[str]
) -> frozenset[str] | None:
    """Return the names as a set, or None if ``given`` is None, which means any body.

    Raises:
        ControlError: If a name is not a link, an object or ``ground``.
    """
    if given is None:
        return None
    names = frozenset((given,) if isinstance(given, str) else given)
    known = [*model.link_by_name, *objects, GROUND]
    for name in sorted(names.difference(known)):
        raise ControlError(
            f"{what}: there is no link or object '{name}'{did_you_mean(name, known)}"
        )
    return names
