"""The contacts of MuJoCo's last step, merged to one item for each pair of names."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from tool0.description.transform import Vector3
from tool0.hardware.engine import Contact

ContactPoint = tuple[Vector3, float, Vector3, Vector3]
"""Its position, its weight in the mean, and the force and the torque there."""


def geom_owners(model: Any) -> tuple[str, ...]:
    """Return the link or object that each geom belongs to, by the geom's number."""
    return tuple(model.geom(i).name.partition("/")[0] for i in range(model.ngeom))


def contact_points(
    model: Any, data: Any, owners: Sequence[str]
) -> Iterator[tuple[tuple[str, str], ContactPoint]]:
    """Yield pairs in contact, and what the first exerts on the second at a point.

    After ``mj_step`` the contacts and their forces are still those that the step was
    made with: only position and velocity are newer.  A wrist's sensor asks a thousand
    times a second, and plain floats are what Python computes with fastest.

    Args:
        model: The ``MjModel``.
        data: Its ``MjData``, after a step.
        owners: The link or object of each geom.
    """
    contacts = data.contact
    wrench = np.zeros(6)
    for i, ((one, two), frame, (x, y, z)) in enumerate(
        zip(
            contacts.geom.tolist(),
            contacts.frame.tolist(),
            contacts.pos.tolist(),
            strict=True,
        )
    ):
        mujoco.mj_contactForce(model, data, i, wrench)
        # In the contact's frame, whose x points from the first shape to the second;
        # what is positive along it pushes the second away.
        fx, fy, fz, tx, ty, tz = wrench.tolist()
        if fx:
            force, torque = _rotated(frame, fx, fy, fz), _rotated(frame, tx, ty, tz)
            yield (owners[one], owners[two]), ((x, y, z), fx, force, torque)


def merge_by_pair(
    points: Iterable[tuple[tuple[str, str], ContactPoint]],
) -> tuple[Contact, ...]:
    """Return each pair's points as one contact, whichever of the two came first."""
    found: dict[tuple[str, str], list[ContactPoint]] = {}
    for pair, point in points:
        if pair[::-1] in found:
            position, weight, (fx, fy, fz), (tx, ty, tz) = point
            reversed_ = position, weight, (-fx, -fy, -fz), (-tx, -ty, -tz)
            found[pair[::-1]].append(reversed_)
        else:
            found.setdefault(pair, []).append(point)
    return tuple(_resultant(*pair, merged) for pair, merged in found.items())


def _resultant(first: str, second: str, points: list[ContactPoint]) -> Contact:
    total = sum(weight for _, weight, _, _ in points)
    px = sum(weight * x for (x, _, _), weight, _, _ in points) / total
    py = sum(weight * y for (_, y, _), weight, _, _ in points) / total
    pz = sum(weight * z for (_, _, z), weight, _, _ in points) / total
    fx = fy = fz = tx = ty = tz = 0.0
    for (x, y, z), _, (ax, ay, az), (bx, by, bz) in points:
        rx, ry, rz = x - px, y - py, z - pz
        fx, fy, fz = fx + ax, fy + ay, fz + az
        tx += bx + ry * az - rz * ay
        ty += by + rz * ax - rx * az
        tz += bz + rx * ay - ry * ax
    return Contact(first, second, (px, py, pz), (fx, fy, fz), (tx, ty, tz))


def _rotated(frame: list[float], x: float, y: float, z: float) -> Vector3:
    """Return a vector in the axes of ``frame``, its rows, in those of the world."""
    a, b, c, d, e, f, g, h, i = frame
    return a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z
