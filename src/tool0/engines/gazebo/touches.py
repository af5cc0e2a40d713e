"""What touches what in Gazebo, told in the names that a URDF and a scene have.

libsdformat lumps links that are fixed into the link that they are fixed to, and names
each shape by where it came from.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from typing import final

import numpy as np

from tool0.description.model import RobotModel
from tool0.hardware.bodies import Matrix, MovingBody, fixed_to_world
from tool0.hardware.engine import Contact

_FIGURES = struct.Struct("=10d")
_SEEN_FROM_SECOND = np.array([1.0] * 4 + [-1.0] * 6)
"""By what the figures change if the two things change places."""
_GROUND = ("ground_plane", "ground")
"""What the model is called in our own world, and in the port."""
_LUMP = "_fixed_joint_lump__"
"""Between the names of a lump and of the link in it, unless that begins as the lump."""
_NUMBERED = re.compile(r"_collision(_\d+)?$")


@final
class Names:
    """The names of one robot's links, there and here."""

    def __init__(
        self, model: RobotModel, bodies: tuple[MovingBody, ...], *, own_world: bool
    ) -> None:
        """Name the links of ``model``, and the ground if the world is ours."""
        self._robot = model.name
        self._ground = dict([_GROUND]) if own_world else {}
        self.body_of_link = {link: "" for link, _ in fixed_to_world(model)}
        """What Gazebo calls the link that a link was lumped into; "" if it is still."""
        for body in bodies:
            for link, _ in body.links:
                self.body_of_link[link] = body.joint.child

    def of(self, model: str, shape: str) -> str:
        """Return the link or object that a shape of Gazebo's belongs to."""
        if model == self._robot:
            link = _NUMBERED.sub("", shape.rpartition(_LUMP)[2])
            return link if link in self.body_of_link else shape
        return self._ground.get(model, model)


def contacts_from(told: bytes, names: Names, root: Matrix) -> tuple[Contact, ...]:
    """Return what the bridge tells, in the axes of the robot's root.

    Args:
        told: All touches, as the bridge tells them.
        names: Of links.
        root: The robot's root in the world, shape (4, 4): moved, not turned.
    """
    sums: dict[tuple[str, str], Matrix] = {}
    for (first, second), figures in _read(told, names):
        if (second, first) in sums:
            sums[second, first] += figures * _SEEN_FROM_SECOND
        elif (first, second) in sums:
            sums[first, second] += figures
        else:
            sums[first, second] = figures
    return tuple(
        _contact(first, second, total, root) for (first, second), total in sums.items()
    )


def _contact(first: str, second: str, total: Matrix, root: Matrix) -> Contact:
    moment, force, torque = total[1:4], total[4:7], total[7:10]
    point = moment / total[0]
    rest = torque - np.cross(point, force)
    return Contact(
        first, second, _vector(point - root[:3, 3]), _vector(force), _vector(rest)
    )


def _vector(values: Matrix) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z


def _read(answer: bytes, names: Names) -> Iterator[tuple[tuple[str, str], Matrix]]:
    """Yield each pair of things with its figures, as ``Touch`` in bridge.cc."""
    rest = answer
    while rest:
        *words, rest = rest.split(b"\0", 4)
        first, one, second, other = (word.decode() for word in words)
        figures = np.array(_FIGURES.unpack_from(rest))
        rest = rest[_FIGURES.size :]
        yield (names.of(first, one), names.of(second, other)), figures
