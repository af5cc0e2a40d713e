"""Arrays with the states of many engines that have the same robot and scene."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from typing import NamedTuple, final

import numpy as np

from tool0.description.scene_state import ObjectState
from tool0.description.transform_arrays import Array, rotated_by
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.engines.mujoco.objects import ObjectStates
from tool0.hardware.engine import Engine


class ObjectArrays(NamedTuple):
    """Poses and velocities of the objects of a scene, in the scene's order."""

    position: Array
    """Positions of the objects [m], shape (n, n_objects, 3)."""
    quat: Array
    """Orientations of the objects as quaternions (w, x, y, z), shape (n, n_objects,
    4)."""
    linear: Array
    """Linear velocities of the objects [m/s], shape (n, n_objects, 3)."""
    turning: Array
    """Angular velocities in the axes of the objects [rad/s], shape (n, n_objects,
    3)."""

    @property
    def angular(self) -> Array:
        """Angular velocities in the root's axes [rad/s], shape (n, n_objects, 3)."""
        return rotated_by(self.quat, self.turning)


def mujoco_engine(engine: Engine) -> MujocoEngine:
    """Return ``engine`` as a MujocoEngine."""
    assert isinstance(engine, MujocoEngine)
    return engine


@final
class ObjectReader:
    """Reader of the states of the objects in n copies of one scene."""

    def __init__(self, first: ObjectStates, n: int) -> None:
        """Prepare to read the objects that are in the ``first`` copy."""
        self._names = first.names
        movable = [k for k, name in enumerate(first.names) if name in first.starts]
        self._movable = np.array(movable, dtype=np.intp)  # takes less time than a list
        self._static: list[Mapping[str, ObjectState]] = []
        self._poses = np.zeros((n, len(first.names), 7))
        """Poses of the static objects.  The rows of movable objects are zero."""

    def read(
        self, q: Array, qd: Array, static: Sequence[Mapping[str, ObjectState]]
    ) -> ObjectArrays:
        """Return the states of all objects.

        ``q`` and ``qd`` are positions and velocities of the free joints, shape (n, 7
        n_movable) and (n, 6 n_movable); ``static`` contains the states of the static
        objects for each copy, or once for all copies.
        """
        if not _are_same(static, self._static):
            self._note(static)
        poses = self._poses.copy()
        speeds = np.zeros((*poses.shape[:2], 6))
        if len(self._movable):
            shape = len(poses), len(self._movable), -1
            poses[:, self._movable] = q.reshape(shape)
            speeds[:, self._movable] = qd.reshape(shape)
        return ObjectArrays(
            poses[..., :3], poses[..., 3:], speeds[..., :3], speeds[..., 3:]
        )

    def _note(self, static: Sequence[Mapping[str, ObjectState]]) -> None:
        """Store the poses of the static objects, which change rarely."""
        self._static = list(static)
        for k, name in enumerate(self._names):
            if k not in self._movable:
                states = [states[name] for states in static]
                self._poses[:, k] = [(*x.position, *x.quat_wxyz) for x in states]


def _are_same(some: Sequence[object], others: Sequence[object]) -> bool:
    return len(some) == len(others) and all(map(operator.is_, some, others))


def read_objects(reader: ObjectReader, engines: Sequence[MujocoEngine]) -> ObjectArrays:
    """Return the states of the objects in each engine."""
    states = [engine.world.states for engine in engines]
    return reader.read(
        np.array([each.position for each in states]),
        np.array([each.velocity for each in states]),
        [each.static for each in states],
    )
