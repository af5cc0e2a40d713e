"""The state of many engines of one robot and scene, as arrays with a row for each."""

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
    """Poses and velocities of the objects, in the scene's order."""

    position: Array
    """[m], shape (n, n_objects, 3)."""
    quat: Array
    """w, x, y, z, shape (n, n_objects, 4)."""
    linear: Array
    """[m/s], shape (n, n_objects, 3)."""
    turning: Array
    """Angular velocities in the objects' own axes [rad/s], shape (n, n_objects, 3)."""

    @property
    def angular(self) -> Array:
        """Angular velocities in the root's axes [rad/s], shape (n, n_objects, 3)."""
        return rotated_by(self.quat, self.turning)


def mujoco_engine(engine: Engine) -> MujocoEngine:
    """Return ``engine``, which is one of MuJoCo."""
    assert isinstance(engine, MujocoEngine)
    return engine


@final
class ObjectReader:
    """Reads the states of the objects of n copies of one scene."""

    def __init__(self, first: ObjectStates, n: int) -> None:
        """Read objects such as those of the ``first`` copy."""
        self._names = first.names
        self._movable = [
            k for k, name in enumerate(first.names) if name in first.starts
        ]
        self._static: list[Mapping[str, ObjectState]] = []
        self._poses = np.zeros((n, len(first.names), 7))
        """Those of the static objects; the others are zero."""

    def read(
        self, q: Array, qd: Array, static: Sequence[Mapping[str, ObjectState]]
    ) -> ObjectArrays:
        """Return the states.

        ``q`` and ``qd`` are those of the free joints, (n, 7 n_movable) and
        (n, 6 n_movable); ``static`` has the states of the other objects in each copy,
        or once for all of them.
        """
        if not _are_same(static, self._static):
            self._note(static)
        poses = self._poses.copy()
        speeds = np.zeros((*poses.shape[:2], 6))
        if self._movable:
            shape = len(poses), len(self._movable), -1
            poses[:, self._movable] = q.reshape(shape)
            speeds[:, self._movable] = qd.reshape(shape)
        return ObjectArrays(
            poses[..., :3], poses[..., 3:], speeds[..., :3], speeds[..., 3:]
        )

    def _note(self, static: Sequence[Mapping[str, ObjectState]]) -> None:
        """Keep the poses of the static objects, which change rarely."""
        self._static = list(static)
        for k, name in enumerate(self._names):
            if k not in self._movable:
                states = [states[name] for states in static]
                self._poses[:, k] = [(*x.position, *x.quat_wxyz) for x in states]


def _are_same(some: Sequence[object], others: Sequence[object]) -> bool:
    return len(some) == len(others) and all(map(operator.is_, some, others))


def read_objects(reader: ObjectReader, engines: Sequence[MujocoEngine]) -> ObjectArrays:
    """Return the objects' states, as ``World.object_states`` of each engine."""
    states = [engine.world.states for engine in engines]
    return reader.read(
        np.array([each.position for each in states]),
        np.array([each.velocity for each in states]),
        [each.static for each in states],
    )
