"""What MuJoCo's contacts did during the last step, one item for each pair of names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from tool0.hardware.engine import Contact


def names_of_geoms(model: Any) -> tuple[str, ...]:
    """Return the link or object that each geom is a shape of, by the geom's number."""
    return tuple(model.geom(i).name.partition("/")[0] for i in range(model.ngeom))


def read_contacts(model: Any, data: Any, names: Sequence[str]) -> tuple[Contact, ...]:
    """Return the forces of the step just made.

    After ``mj_step`` the contacts and their forces are still those that the step was
    made with: only position and velocity are newer.

    Args:
        model: The ``MjModel``.
        data: Its ``MjData``, after a step.
        names: What each geom is a shape of.
    """
    n = data.ncon
    if n == 0:
        return ()
    contacts = data.contact
    points, frames = contacts.pos, contacts.frame.reshape(n, 3, 3)
    wrench = np.zeros(6)
    touching: dict[tuple[str, str], list[_Point]] = {}
    for i, (one, two) in enumerate(contacts.geom.tolist()):
        mujoco.mj_contactForce(model, data, i, wrench)
        if not wrench[0]:
            continue
        # In the contact's frame, whose x points from the first shape to the second;
        # what is positive along it pushes the second away.
        force, torque = wrench[:3] @ frames[i], wrench[3:] @ frames[i]
        pair = names[one], names[two]
        if pair[::-1] in touching:
            pair, force, torque = pair[::-1], -force, -torque
        touching.setdefault(pair, []).append((points[i], wrench[0], force, torque))
    return tuple(_as_one(*pair, met) for pair, met in touching.items())


_Point = tuple[Any, float, Any, Any]
"""Where, how hard it presses, the force and the torque of one point of contact."""


def _as_one(first: str, second: str, met: list[_Point]) -> Contact:
    pressing = sum(point[1] for point in met)
    middle = sum(point * normal for point, normal, _, _ in met) / pressing
    total = sum(force for _, _, force, _ in met)
    turning = sum(
        torque + np.cross(point - middle, force) for point, _, force, torque in met
    )
    return Contact(first, second, _three(middle), _three(total), _three(turning))


def _three(vector: Any) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
