"""What MuJoCo's contacts did during the last step, one item for each pair of names."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from tool0.description.transform import Vector3
from tool0.hardware.engine import Contact


def names_of_geoms(model: Any) -> tuple[str, ...]:
    """Return the link or object that each geom is a shape of, by the geom's number."""
    return tuple(model.geom(i).name.partition("/")[0] for i in range(model.ngeom))


Touch = tuple[Vector3, float, Vector3, Vector3]
"""A point, how much it counts, and the force and the torque that act there."""


def read_contacts(
    model: Any, data: Any, names: Sequence[str]
) -> Iterator[tuple[tuple[str, str], Touch]]:
    """Yield pairs that touch, and what the first does to the second at a point.

    After ``mj_step`` the contacts and their forces are still those that the step was
    made with: only position and velocity are newer.  A wrist's sensor asks a thousand
    times a second, and plain floats are what Python computes with fastest.

    Args:
        model: The ``MjModel``.
        data: Its ``MjData``, after a step.
        names: What each geom is a shape of.
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
            force, torque = _turned(frame, fx, fy, fz), _turned(frame, tx, ty, tz)
            yield (names[one], names[two]), ((x, y, z), fx, force, torque)


def one_for_each_pair(
    touches: Iterable[tuple[tuple[str, str], Touch]],
) -> tuple[Contact, ...]:
    """Return each pair's touches as one contact, whichever of the two came first."""
    found: dict[tuple[str, str], list[Touch]] = {}
    for pair, touch in touches:
        if pair[::-1] in found:
            point, pressing, (fx, fy, fz), (tx, ty, tz) = touch
            turned = point, pressing, (-fx, -fy, -fz), (-tx, -ty, -tz)
            found[pair[::-1]].append(turned)
        else:
            found.setdefault(pair, []).append(touch)
    return tuple(_as_one(*pair, met) for pair, met in found.items())


def _as_one(first: str, second: str, met: list[Touch]) -> Contact:
    pressing = sum(weight for _, weight, _, _ in met)
    px = sum(weight * x for (x, _, _), weight, _, _ in met) / pressing
    py = sum(weight * y for (_, y, _), weight, _, _ in met) / pressing
    pz = sum(weight * z for (_, _, z), weight, _, _ in met) / pressing
    fx = fy = fz = tx = ty = tz = 0.0
    for (x, y, z), _, (ax, ay, az), (bx, by, bz) in met:
        rx, ry, rz = x - px, y - py, z - pz
        fx, fy, fz = fx + ax, fy + ay, fz + az
        tx += bx + ry * az - rz * ay
        ty += by + rz * ax - rx * az
        tz += bz + rx * ay - ry * ax
    return Contact(first, second, (px, py, pz), (fx, fy, fz), (tx, ty, tz))


def _turned(frame: list[float], x: float, y: float, z: float) -> Vector3:
    """Return a vector in the axes of ``frame``, its rows, in those of the world."""
    a, b, c, d, e, f, g, h, i = frame
    return a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z
