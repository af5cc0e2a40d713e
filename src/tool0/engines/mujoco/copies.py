"""The state of many engines of one robot and scene, as arrays with a row for each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tool0.engines.mujoco.engine import MujocoEngine
from tool0.hardware.engine import Engine

Array = NDArray[np.float64]


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
    first, n = engines[0].world.states, len(engines)
    n_objects = len(first.names)
    position, linear, angular = np.zeros((3, n, n_objects, 3))
    quat = np.zeros((n, n_objects, 4))
    movable = [k for k, name in enumerate(first.names) if first.is_movable(name)]
    if movable:
        shape = n, len(movable), -1
        q = np.array([engine.world.states.position for engine in engines])
        qd = np.array([engine.world.states.velocity for engine in engines])
        q, qd = q.reshape(shape), qd.reshape(shape)
        position[:, movable], quat[:, movable] = q[..., :3], q[..., 3:]
        linear[:, movable] = qd[..., :3]
        angular[:, movable] = _rotated(q[..., 3:], qd[..., 3:])
    static = [k for k in range(n_objects) if k not in movable]
    for i, engine in enumerate(engines if static else ()):
        states = engine.world.states.static
        for k in static:
            state = states[first.names[k]]
            position[i, k], quat[i, k] = state.position, state.quat_wxyz
    return ObjectArrays(position, quat, linear, angular)


def _rotated(quat: Array, vectors: Array) -> Array:
    """Return ``vectors`` rotated by ``quat``, as ``ObjectStates`` does to the bit."""
    w, x, y, z = np.moveaxis(quat, -1, 0)
    a, b, c = np.moveaxis(vectors, -1, 0)
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return np.stack(
        [
            a + w * p + y * r - z * q,
            b + w * q + z * p - x * r,
            c + w * r + x * q - y * p,
        ],
        axis=-1,
    )
