"""Ways in which a gripper holds an object between its pads."""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from tool0.description.transform_arrays import yaws_of_quats
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array


@final
class Hold(NamedTuple):
    """Way in which the pads hold an upright object from above."""

    width: float | Array
    """Width of the object between the pads [m]; it is an array of shape (n,) if the
    copies differ."""
    point: tuple[float, float, float | Array] = (0.0, 0.0, 0.0)
    """Position of the TCP in the object's frame [m]; z may be an array of shape
    (n,)."""
    turns: int = 4
    """Number of yaws per full turn at which the pads fit: 4 for a cube, 2 for a bar
    along x."""
    hover: float | None = None
    """Height of the TCP in the root frame at which the fingers clear all objects [m];
    by default, the height at which they clear cubes."""
    opening: float | None = None
    """Opening of the gripper around the object [m]; the default is the gripper's
    maximum opening."""

    def places(self, position: Array, quat: Array) -> Array:
        """Return the positions of the TCP in the root frame [m], shape (n, 3).

        Args:
            position: Positions of the object in the root frame [m], shape (n, 3).
            quat: Orientations of the object (w, x, y, z), shape (n, 4).  Only the yaw
                angles are used.
        """
        x, y, z = self.point
        if x == y == 0.0:  # independent of the yaw
            found = position.copy()
            found[:, 2] += z
            return found
        yaw = yaws_of_quats(quat)
        c, s = np.cos(yaw), np.sin(yaw)
        away = np.stack([c * x - s * y, s * x + c * y, np.full(len(yaw), z)], axis=1)
        return np.asarray(position + away)

    def turn(self, yaw: Array, quat: Array) -> Array:
        """Return the smallest turn from the TCP's yaw to a matching yaw [rad], (n,).

        ``quat`` is the object's orientation (w, x, y, z), shape (n, 4).
        """
        return folded(yaws_of_quats(quat) - yaw, self.turns)


@final
class Cube(NamedTuple):
    """A cube in each copy; the fields are arrays of shape (n,) if sizes are random."""

    edge: float | Array
    """Edge of the cube [m]."""
    grasp_height: float | Array
    """Height of the TCP above the cube's support when the gripper grasps the cube
    [m]."""

    @staticmethod
    def of(space: Workspace, object_size: Array, k: int = 0) -> Cube:
        """Return object ``k`` as a cube; ``object_size`` is the field of ``State``."""
        if not space.has_sizes:
            return Cube(space.edge, space.grasp_height)
        edge = np.nan_to_num(object_size[:, k, 0], nan=space.edge)
        return Cube(edge, space.grasp_heights(edge))

    @property
    def hold(self) -> Hold:
        """The way in which the gripper holds the cube."""
        return Hold(self.edge, (0.0, 0.0, self.grasp_height - self.edge / 2.0))


def folded(angle: Array, turns: int) -> Array:
    """Return the smallest equivalent angle for a ``turns``-fold symmetric object.

    ``angle`` [rad] may have any shape; the results are within ±π / ``turns``.
    """
    part = 2.0 * np.pi / turns
    return np.asarray(np.remainder(angle + part / 2.0, part) - part / 2.0)
