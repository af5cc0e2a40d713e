"""The state of many engines of one robot and scene, as arrays with a row for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

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
    angular: Array
    """[rad/s], shape (n, n_objects, 3)."""


def mujoco_engine(engine: Engine) -> MujocoEngine:
    """Return ``engine``, which is one of MuJoCo."""
    assert isinstance(engine, MujocoEngine)
    return engine


def joint_views(engine: MujocoEngine) -> tuple[Array, Array]:
    """Return views of the joints' positions and velocities.

    They hold as long as no object is spawned, deleted or attached.
    """
    n = len(engine.joint_names)
    return engine.data.qpos[:n], engine.data.qvel[:n]


def object_arrays(engines: Sequence[MujocoEngine]) -> ObjectArrays:
    """Return the objects' states, as ``World.object_states`` of each engine."""
    states = [engine.world.states for engine in engines]
    return object_arrays_of(
        states[0],
        np.array([each.position for each in states]),
        np.array([each.velocity for each in states]),
        [each.static for each in states],
    )


def object_arrays_of(
    first: ObjectStates,
    q: Array,
    qd: Array,
    static: Sequence[Mapping[str, ObjectState]],
) -> ObjectArrays:
    """Return the states of the objects that ``first`` has, in n copies.

    ``q`` and ``qd`` are those of the free joints, (n, 7 n_movable) and
    (n, 6 n_movable); ``static`` has the states of the other objects in each copy, or
    once for all of them.
    """
    n, n_objects = len(q), len(first.names)
    position, linear, angular = np.zeros((3, n, n_objects, 3))
    quat = np.zeros((n, n_objects, 4))
    movable = [k for k, name in enumerate(first.names) if first.is_movable(name)]
    if movable:
        shape = n, len(movable), -1
        q, qd = q.reshape(shape), qd.reshape(shape)
        position[:, movable], quat[:, movable] = q[..., :3], q[..., 3:]
        linear[:, movable] = qd[..., :3]
        angular[:, movable] = rotated_by(q[..., 3:], qd[..., 3:])
    for k, name in enumerate(first.names):
        if k not in movable:
            position[:, k] = [states[name].position for states in static]
            quat[:, k] = [states[name].quat_wxyz for states in static]
    return ObjectArrays(position, quat, linear, angular)
