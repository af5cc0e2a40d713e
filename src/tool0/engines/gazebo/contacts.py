"""Gazebo's contacts, with the names of URDF and scene.

libsdformat lumps fixed links into the link that they are fixed to, and names each shape
by its original link.
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

_NUMBERS = struct.Struct("=10d")
_REVERSED = np.array([1.0] * 4 + [-1.0] * 6)
"""Factors of the numbers if the two names are swapped."""
_GROUND = ("ground_plane", "ground")
"""The name of the model in our own world, and the name that tool0 uses."""
_LUMP = "_fixed_joint_lump__"
"""Between the names of a lump and of its link, unless that name begins as the lump."""
_NUMBERED = re.compile(r"_collision(_\d+)?$")


@final
class LinkNames:
    """The names of one robot's links in Gazebo and in the URDF."""

    def __init__(
        self, model: RobotModel, bodies: tuple[MovingBody, ...], *, own_world: bool
    ) -> None:
        """Name the links of ``model``, and the ground if the world is ours."""
        self._robot = model.name
        self._ground = dict([_GROUND]) if own_world else {}
        self.body_of_link = {link: "" for link, _ in fixed_to_world(model)}
        """URDF link → the Gazebo link that it was lumped into; "" for the world."""
        for body in bodies:
            for link, _ in body.links:
                self.body_of_link[link] = body.joint.child

    def owner(self, model: str, shape: str) -> str:
        """Return the link or object that a shape of Gazebo's belongs to."""
        if model == self._robot:
            link = _NUMBERED.sub("", shape.rpartition(_LUMP)[2])
            return link if link in self.body_of_link else shape
        return self._ground.get(model, model)


def unpack_contacts(
    packed: bytes, names: LinkNames, root: Matrix
) -> tuple[Contact, ...]:
    """Return one contact for each pair, in the axes of the robot's root.

    ``packed`` has all pairs of shapes, as the bridge sends them; ``root`` is the
    robot's root in the world, shape (4, 4): moved, not rotated.
    """
    sums: dict[tuple[str, str], Matrix] = {}
    for (first, second), numbers in _unpack(packed, names):
        if (second, first) in sums:
            sums[second, first] += numbers * _REVERSED
        elif (first, second) in sums:
            sums[first, second] += numbers
        else:
            sums[first, second] = numbers
    found = []
    for (first, second), total in sums.items():
        moment, force, torque = total[1:4], total[4:7], total[7:10]
        point = moment / total[0]
        vectors = (point - root[:3, 3], force, torque - np.cross(point, force))
        found.append(Contact(first, second, *(tuple(v.tolist()) for v in vectors)))
    return tuple(found)


def _unpack(
    packed: bytes, names: LinkNames
) -> Iterator[tuple[tuple[str, str], Matrix]]:
    """Yield each pair of names with its numbers (see ``ContactSum`` in bridge.cc)."""
    rest = packed
    while rest:
        *words, rest = rest.split(b"\0", 4)
        first, one, second, other = (word.decode() for word in words)
        numbers = np.array(_NUMBERS.unpack_from(rest))
        rest = rest[_NUMBERS.size :]
        yield (names.owner(first, one), names.owner(second, other)), numbers
