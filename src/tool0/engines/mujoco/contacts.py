"""What MuJoCo's contacts did during the last step, one item for each pair of names."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from tool0.hardware.engine import Contact


def names_of_geoms(model: Any) -> tuple[str, ...]:
    """Return the link or object that each geom is a shape of, by the geom's number."""
    return tuple(model.geom(i).name.partition("/")[0] for i in range(model.ngeom))


Touch = tuple[Any, float, Any, Any]
"""A point, how much it counts, and the force and the torque that act there."""


def read_contacts(
    model: Any, data: Any, names: Sequence[str]
) -> Iterator[tuple[tuple[str, str], Touch]]:
    """Yield pairs that touch, and what the first does to the second at a point.

    After ``mj_step`` the contacts and their forces are still those that the step was
    made with: only position and velocity are newer.

    Args:
        model: The ``MjModel``.
        data: Its ``MjData``, after a step.
        names: What each geom is a shape of.
    """
    contacts = data.contact
    points, frames = contacts.pos, contacts.frame.reshape(-1, 3, 3)
    wrench = np.zeros(6)
    for i, (one, two) in enumerate(contacts.geom.tolist()):
        mujoco.mj_contactForce(model, data, i, wrench)
        # In the contact's frame, whose x points from the first shape to the second;
        # what is positive along it pushes the second away.
        if pressing := float(wrench[0]):
            force, torque = wrench[:3] @ frames[i], wrench[3:] @ frames[i]
            yield (names[one], names[two]), (points[i], pressing, force, torque)


def one_for_each_pair(
    touches: Iterable[tuple[tuple[str, str], Touch]],
) -> tuple[Contact, ...]:
    """Return each pair's touches as one contact, whichever of the two came first."""
    found: dict[tuple[str, str], list[Touch]] = {}
    for pair, touch in touches:
        if pair[::-1] in found:
            point, pressing, force, torque = touch
            found[pair[::-1]].append((point, pressing, -force, -torque))
        else:
            found.setdefault(pair, []).append(touch)
    return tuple(_as_one(*pair, met) for pair, met in found.items())


def _as_one(first: str, second: str, met: list[Touch]) -> Contact:
    pressing = sum(weight for _, weight, _, _ in met)
    middle = sum(point * weight for point, weight, _, _ in met) / pressing
    total = sum(force for _, _, force, _ in met)
    turning = sum(
        torque + np.cross(point - middle, force) for point, _, force, torque in met
    )
    return Contact(first, second, _three(middle), _three(total), _three(turning))


def _three(vector: Any) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
