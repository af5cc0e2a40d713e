"""State of the copies as read-only arrays, and the guards of the state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from tool0.batch.backend import BatchBackend
from tool0.batch.one_thread import OneThread
from tool0.description.scene_state import ObjectState
from tool0.errors import ControlError
from tool0.kinematics.chain import Array
from tool0.protocol.state import Snapshot
from tool0.simulation.core import Core

if TYPE_CHECKING:
    from tool0.engines.mujoco.copies import ObjectArrays

FrozenArray = TypeVar("FrozenArray", bound=NDArray[Any])


def frozen(values: FrozenArray) -> FrozenArray:
    """Return ``values`` after making the array read-only."""
    values.flags.writeable = False
    return values


@final
class State:
    """State of n copies, read from the backend and cached until the state changes."""

    def __init__(self, copies: BatchBackend, cores: Sequence[Core]) -> None:
        """Read the state of ``copies``; ``cores`` has the core of each copy."""
        self._copies = copies
        self._cores = cores
        self.n = len(cores)
        """Number of copies."""
        self.joint_names = cores[0].engine.joint_names
        """All movable joints, in the order of the arrays of joint states."""
        self._diverged: NDArray[np.bool_] | None = None
        self._joints: tuple[Array, Array, Array] | None = None
        self._objects: ObjectArrays | None = None
        self._is_closed = False
        self.alone = OneThread()
        """Guard that a thread enters to read the state."""
        self.changing = self.alone.then(self._forget)
        """Guard that a thread enters to change the state; entering the guard raises
        ControlError if the batch is closed."""

    def close(self) -> None:
        """Refuse all further changes of the state."""
        self._is_closed = True

    @property
    def time(self) -> Array:
        """Simulated time since the last reset of each copy [s], shape (n,)."""
        with self.alone:
            return frozen(self._copies.time)

    @property
    def diverged(self) -> NDArray[np.bool_]:
        """Whether each copy has stopped because its physics failed, shape (n,)."""
        found = self._diverged
        if found is None:
            with self.alone:
                found = self._diverged = frozen(self._copies.has_diverged.copy())
        return found

    def joints(self) -> tuple[Array, Array, Array]:
        """Return the positions, velocities and efforts of the joints, (n, n_joints)."""
        found = self._joints
        if found is None:
            with self.alone:
                position, velocity, effort = map(frozen, self._copies.states())
                found = self._joints = position, velocity, effort
        return found

    def objects(self) -> ObjectArrays:
        """Return the poses and velocities of the objects."""
        found = self._objects
        if found is None:
            with self.alone:
                found = self._objects = self._copies.objects()
                for array in found:
                    frozen(array)
        return found

    def snapshot(self, i: int) -> Snapshot:
        """Return the state of one copy for rendering."""
        core = self._cores[i]
        arrays, time = self.objects(), float(self.time[i])
        states = (arrays.position, arrays.quat, arrays.linear, arrays.angular)
        rows = zip(*(values[i].tolist() for values in states), strict=True)
        position, velocity, effort = (tuple(q[i].tolist()) for q in self.joints())
        return Snapshot(
            time=time,
            tick=round(time / core.control_period),
            joint_names=self.joint_names,
            position=position,
            velocity=velocity,
            effort=effort,
            controllers=core.manager.list(),
            is_paused=False,
            is_stopped=False,
            real_time_factor=0.0,
            overruns=0,
            scene=core.scene.objects,
            objects=tuple(
                ObjectState(item.name, *map(tuple, row))
                for item, row in zip(core.scene.objects, rows, strict=True)
            ),
        )

    def _forget(self) -> None:
        """Discard the cached arrays, because the state changes."""
        if self._is_closed:
            raise ControlError("the batch is closed")
        self._diverged = self._joints = self._objects = None
