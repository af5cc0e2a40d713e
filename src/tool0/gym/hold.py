"""How the pads hold an object."""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from tool0.description.transform_arrays import yaws_of_quats
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array


@final
class Hold(NamedTuple):
    """How the pads hold an object that stands upright, from above."""

    width: float | Array
    """Width of the object between the pads [m]; shape (n,) if copies differ."""
    point: tuple[float, float, float | Array] = (0.0, 0.0, 0.0)
    """Position of the tcp in the object's frame [m]; z as ``width``."""
    turns: int = 4
    """Yaws at which the pads fit, in a full turn: 4 for a cube, 2 for a bar along x."""
    hover: float | None = None
    """Height of the tcp in the root at which the fingers pass over everything [m]; over
    cubes, if left out."""
    opening: float | None = None
    """Opening of the gripper around the object [m]; the largest, if left out."""

    def places(self, position: Array, quat: Array) -> Array:
        """Return the positions of the tcp in the root [m], shape (n, 3).

        Args:
            position: Of the object in the root [m], shape (n, 3).
            quat: Its orientations w, x, y, z, shape (n, 4); only their yaw counts.
        """
        x, y, z = self.point
        if x == y == 0.0:  # no yaw moves it
            found = position.copy()
            found[:, 2] += z
            return found
        yaw = yaws_of_quats(quat)
        c, s = np.cos(yaw), np.sin(yaw)
        away = np.stack([c * x - s * y, s * x + c * y, np.full(len(yaw), z)], axis=1)
        return np.asarray(position + away)

    def turn(self, yaw: Array, quat: Array) -> Array:
        """Return the smallest turn from a yaw of the tcp to one that fits [rad], (n,).

        ``quat`` is the object's, w, x, y, z, shape (n, 4).
        """
        return folded(yaws_of_quats(quat) - yaw, self.turns)


@final
class Cube(NamedTuple):
    """A cube of each copy.  The numbers are arrays, (n,), if sizes are random."""

    edge: float | Array
    """[m]"""
    grasp_height: float | Array
    """Height of the tcp above what carries the cube, when it grasps it [m]."""

    @staticmethod
    def of(space: Workspace, object_size: Array, k: int = 0) -> Cube:
        """Return object ``k``; ``object_size`` is that of the ``State``."""
        if not space.has_sizes:
            return Cube(space.edge, space.grasp_height)
        edge = np.nan_to_num(object_size[:, k, 0], nan=space.edge)
        return Cube(edge, space.grasp_heights(edge))

    @property
    def hold(self) -> Hold:
        """How it is held."""
        return Hold(self.edge, (0.0, 0.0, self.grasp_height - self.edge / 2.0))


def folded(angle: Array, turns: int) -> Array:
    """Return the smallest angle with the same effect on what has ``turns`` symmetries.

    Angles are in [rad], of any shape; the result is within half of such a turn.
    """
    part = 2.0 * np.pi / turns
    return np.asarray(np.remainder(angle + part / 2.0, part) - part / 2.0)
