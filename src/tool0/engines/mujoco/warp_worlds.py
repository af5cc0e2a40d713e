"""Many copies of one compiled model, which MuJoCo Warp steps on a GPU."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any, final

import mujoco
import mujoco_warp
import numpy as np
import warp as wp
from mujoco_warp import OverflowType
from numpy.typing import NDArray

from tool0.engines.mujoco.copies import ObjectArrays, ObjectReader
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.engines.mujoco.warp_kernels import (
    find_touching,
    finish_step,
    place_object,
    set_body_mass,
    set_geom_friction,
    set_state,
    sum_normal_forces,
)
from tool0.engines.mujoco.world import geom_owners
from tool0.errors import ControlError, EngineError, EngineUnavailableError
from tool0.hardware.engine import LARGEST_VELOCITY

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

CONTACTS, CONTACTS_PER_OBJECT = 64, 16
"""Numbers of contacts for which memory is allocated in each copy: for the robot, and
for each movable object."""
CONTACTS_PER_PAIR = 8
"""Largest number of contacts between two geoms, which occurs between two boxes."""
ROWS, ROWS_PER_CONTACT = 64, 4
"""Numbers of constraint rows for which memory is allocated in each copy: without
contacts (mimic joints, stops and friction), and for each contact."""
FIELDS_OF_OBJECTS = (
    "body_mass",
    "body_subtreemass",
    "body_inertia",
    "body_invweight0",
    "dof_invweight0",
    "geom_friction",
    "pair_friction",
)
"""Fields of the model that have one row per world, for the masses and friction
coefficients of objects."""
FAILURES = int(
    OverflowType.ALL & ~(OverflowType.ITERATIONS | OverflowType.LS_ITERATIONS)
)
"""Overflows that lead to dropped contacts or constraints.  The iteration limits of
solvers are not included, since reaching a limit only makes the results less accurate,
as on the CPU."""


def check_device(device: str) -> str:
    """Return Warp's name for ``device``, such as "cuda:1", or "cpu" for "warp:cpu".

    Raises:
        EngineUnavailableError: If Warp does not find the device.
    """
    wp.config.log_level = max(wp.config.log_level, wp.LOG_WARNING)
    wp.init()
    name = device.removeprefix("warp:")
    known = [found.alias for found in wp.get_devices()]
    if name == "cuda" and wp.is_cuda_available():
        return str(wp.get_cuda_device().alias)
    if name not in known:
        raise EngineUnavailableError(
            f"there is no device '{device}': Warp finds {', '.join(known)}; a GPU "
            "needs NVIDIA's driver (nvidia-smi shows it)"
        )
    return name


@final
class WarpWorlds:
    """The n copies of a robot and its objects on a Warp device, in single precision.

    Unless stated otherwise, arguments and results that are arrays have double precision
    and n rows.
    """

    def __init__(self, engine: MujocoEngine, n: int, device: str) -> None:
        """Copy the state of ``engine`` n times to the Warp device called ``device``.

        Raises:
            EngineError: If MuJoCo Warp does not support the model.
        """
        self._device = device
        self._engine = engine
        self._objects = ObjectReader(engine.world.states, n)
        self._n, self._n_joints = n, len(engine.joint_names)
        model = copy.copy(engine.model)
        # MuJoCo Warp never resets a diverged world, and rejects the flag that disables
        # resets.
        model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        n_contacts = CONTACTS + CONTACTS_PER_OBJECT * len(engine.world.states.starts)
        with wp.ScopedDevice(device):
            try:
                self._model = mujoco_warp.put_model(model)
            except NotImplementedError as error:
                raise EngineError(
                    f"MuJoCo Warp does not support the scene: {error}"
                ) from error
            # Overflows are reported by ``has_diverged`` instead.
            self._model.opt.warn_overflow = 0
            for name in FIELDS_OF_OBJECTS:
                field = getattr(self._model, name).numpy()
                rows = np.repeat(field, n, axis=0)
                kind = getattr(self._model, name).dtype
                setattr(self._model, name, wp.array(rows, dtype=kind))
            # All worlds share the memory of contacts.  Memory is allocated for all
            # possible contacts of one world in addition to the usual number of contacts
            # of the other worlds.  The constraint rows, which are separate for each
            # world, overflow earlier.
            most = CONTACTS_PER_PAIR * len(self._model.nxn_geom_pair_filtered)
            self._data = data = mujoco_warp.make_data(
                model,
                nworld=n,
                naconmax=n * n_contacts + most,
                njmax=ROWS + ROWS_PER_CONTACT * n_contacts,
            )
            self.steps = wp.zeros(n, dtype=int)
            """Number of steps of each world since the world's reset, as a Warp
            array."""
            self.divergence = wp.zeros(n, dtype=int)
            """Value 1 for each world that was stopped because it diverged, as a Warp
            array."""
            self._start = engine.data.qpos.copy()
            self._parked = wp.array(self._start.astype(np.float32), dtype=float)
            self._measured = wp.zeros((n, model.nq), dtype=float)
        self.position = data.qpos
        """Positions of the joints, followed by those of the objects, as a Warp array,
        shape (n, nq)."""
        self.velocity = data.qvel
        self.motors = data.ctrl
        self.reset(np.arange(n), np.tile(self._start[: self._n_joints], (n, 1)))

    # ---- time -----------------------------------------------------------------------

    def step(self) -> None:
        """Launch one step of all worlds; worlds that have diverged do not move."""
        data = self._data
        with wp.ScopedDevice(self._device):
            mujoco_warp.step(self._model, data)
            wp.launch(
                finish_step,
                dim=self._n,
                inputs=[
                    LARGEST_VELOCITY**2,
                    FAILURES,
                    data.overflow,
                    self._parked,
                    data.qpos,
                    data.qvel,
                    data.qacc_warmstart,
                    self._measured,
                    self.divergence,
                    self.steps,
                ],
            )

    def recorded(self, launch: Callable[[], None]) -> Callable[[], None]:
        """Return a CUDA graph that combines all launches of ``launch`` in one launch.

        The kernels must have been compiled.  Without CUDA, the method returns
        ``launch``.
        """
        device = wp.get_device(self._device)
        if not device.is_cuda:
            return launch
        with wp.ScopedDevice(device), wp.ScopedCapture() as capture:
            launch()
        graph = capture.graph
        return lambda: wp.capture_launch(graph)

    def reset(self, rows: Indices, joints: Array) -> None:
        """Reset worlds to joint positions [rad | m], shape (len(rows), n_joints).

        The objects of these worlds move to their start poses, and all bodies are at
        rest.
        """
        data = self._data
        start = np.tile(self._start, (self._n, 1))
        start[rows, : self._n_joints] = joints
        with wp.ScopedDevice(self._device):
            wp.launch(
                set_state,
                dim=self._n,
                inputs=[
                    self._chosen(rows),
                    wp.array(start.astype(np.float32), dtype=float),
                    data.qpos,
                    data.qvel,
                    data.qacc_warmstart,
                    data.ctrl,
                    self._measured,
                    data.time,
                    data.overflow,
                    self.divergence,
                    self.steps,
                ],
            )

    def _chosen(self, rows: Indices) -> Any:
        mask = np.zeros(self._n, dtype=np.int32)
        mask[rows] = 1
        return wp.array(mask, dtype=int, device=self._device)

    # ---- the state ------------------------------------------------------------------

    @property
    def has_diverged(self) -> NDArray[np.bool_]:
        """Whether each world has stopped because its physics diverged, shape (n,)."""
        return np.asarray(self.divergence.numpy() != 0)

    def joints(self) -> tuple[Array, Array]:
        """Return joint positions and velocities, each of shape (n, n_joints).

        The units are [rad | m] and [rad/s | m/s].
        """
        k = self._n_joints
        return _doubles(self._measured)[:, :k], _doubles(self.velocity)[:, :k]

    @property
    def joint_arrays(self) -> tuple[Any, Any]:
        """Joint positions and velocities as Warp arrays, which change in each step."""
        k = self._n_joints
        return self._measured[:, :k], self.velocity[:, :k]

    @property
    def object_arrays(self) -> tuple[Any, Any, Any, Any]:
        """States of the m movable objects as Warp arrays, which change in each step.

        The arrays are positions in the root, shape (n, m, 3), orientations (w, x, y, z)
        in the root, shape (n, m, 4), linear velocities in the root's axes, shape (n, m,
        3), and angular velocities in the object's axes, shape (n, m, 3).
        """
        q, qd, k = self._measured, self.velocity, self._n_joints
        m = len(self._engine.world.states.starts)

        def view(base: Any, first: int, width: int, stride: int) -> Any:
            found = wp.array(
                ptr=base.ptr + base.strides[1] * (k + first),
                dtype=float,
                shape=(self._n, m, width),
                strides=(base.strides[0], base.strides[1] * stride, base.strides[1]),
                device=base.device,
            )
            found._ref = base  # keeps the memory alive, as slices in Warp do
            return found

        return view(q, 0, 3, 7), view(q, 3, 4, 7), view(qd, 0, 3, 6), view(qd, 3, 3, 6)

    def objects(self) -> ObjectArrays:
        """Return the states of the objects in the root."""
        states, k = self._engine.world.states, self._n_joints
        q, qd = _doubles(self._measured)[:, k:], _doubles(self.velocity)[:, k:]
        return self._objects.read(q, qd, [states.static])

    def place(self, name: str, rows: Indices, position: Array, quat: Array) -> None:
        """Place a movable object at rest.

        ``position`` [m] has the shape (len(rows), 3), and ``quat`` (w, x, y, z) has the
        shape (len(rows), 4).

        Raises:
            ControlError: If the object is fixed.
        """
        first = self._engine.world.states.starts.get(name)
        if first is None:
            raise ControlError(
                f"object '{name}' is fixed; on a GPU only movable ones can be placed"
            )
        pose = np.zeros((self._n, 7), dtype=np.float32)
        pose[rows, :3] = position
        pose[rows, 3:] = quat / np.linalg.norm(quat, axis=1, keepdims=True)
        k, data = self._n_joints, self._data
        with wp.ScopedDevice(self._device):
            wp.launch(
                place_object,
                dim=self._n,
                inputs=[
                    self._chosen(rows),
                    wp.vec2i(k + first[0], k + first[1]),
                    wp.array(pose, dtype=float),
                    data.qpos,
                    self._measured,
                    data.qvel,
                    data.qacc_warmstart,
                ],
            )

    def set_mass(self, name: str, rows: Indices, mass: Array) -> None:
        """Set masses [kg], shape (len(rows),), of a movable object in some worlds."""
        model, first = self._model, self._engine.world.states.starts[name]
        given = np.zeros(self._n, dtype=np.float32)
        given[rows] = mass
        with wp.ScopedDevice(self._device):
            wp.launch(
                set_body_mass,
                dim=self._n,
                inputs=[
                    self._chosen(rows),
                    self._engine.model.body(name).id,
                    self._n_joints + first[1],
                    wp.array(given, dtype=float),
                    model.body_mass,
                    model.body_subtreemass,
                    model.body_inertia,
                    model.body_invweight0,
                    model.dof_invweight0,
                ],
            )

    def set_friction(self, name: str, rows: Indices, friction: Array) -> None:
        """Set the friction coefficients, shape (len(rows),), of an object."""
        compiled, model = self._engine.model, self._model
        geoms = np.flatnonzero(compiled.geom_bodyid == compiled.body(name).id)
        ends = np.stack([compiled.pair_geom1, compiled.pair_geom2], axis=1)
        pairs = np.flatnonzero(np.isin(ends, geoms).any(axis=1))
        given = np.zeros(self._n, dtype=np.float32)
        given[rows] = friction
        with wp.ScopedDevice(self._device):
            wp.launch(
                set_geom_friction,
                dim=self._n,
                inputs=[
                    self._chosen(rows),
                    wp.array(geoms, dtype=int),
                    wp.array(pairs, dtype=int),
                    wp.array(ends[pairs], dtype=wp.vec2i),
                    wp.array(given, dtype=float),
                    model.geom_friction,
                    model.pair_friction,
                ],
            )

    def normal_forces(self, links: Sequence[str]) -> Array:
        """Return the sum of the normal forces on each link [N], shape (n, n_links)."""
        contact = self._data.contact
        owners = geom_owners(self._engine.model)
        owner = np.array([[each == link for link in links] for each in owners])
        with wp.ScopedDevice(self._device):
            found = wp.zeros((self._n, len(links)), dtype=float)
            wp.launch(
                sum_normal_forces,
                dim=contact.worldid.shape[0],
                inputs=[
                    self._data.nacon,
                    contact.worldid,
                    contact.geom,
                    contact.efc_address,
                    self._data.efc.force,
                    wp.array(owner.astype(np.int32), dtype=int),
                    found,
                ],
            )
        return _doubles(found)

    def are_touching(
        self, first: frozenset[str], second: frozenset[str] | None
    ) -> NDArray[np.bool_]:
        """Return whether ``first`` presses on ``second``, shape (n,).

        If ``second`` is None, contacts with all items are considered.
        """
        contact = self._data.contact
        owners = geom_owners(self._engine.model)
        side = np.array(
            [[each in first, second is None or each in second] for each in owners]
        )
        with wp.ScopedDevice(self._device):
            found = wp.zeros(self._n, dtype=int)
            wp.launch(
                find_touching,
                dim=contact.worldid.shape[0],
                inputs=[
                    self._data.nacon,
                    contact.worldid,
                    contact.geom,
                    contact.efc_address,
                    self._data.efc.force,
                    self.steps,
                    wp.array(side.astype(np.int32), dtype=int),
                    found,
                ],
            )
        return np.asarray(found.numpy() != 0)


def _doubles(array: Any) -> Array:
    """Return a copy of a device array on the host."""
    return np.asarray(array.numpy(), dtype=np.float64)
