"""The cores of a batch, which the kernel executes together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from tool0.batch.arguments import Indices, chosen
from tool0.batch.backend import (
    DeviceArrays,
    Names,
    ObjectField,
    changed_object,
    needs_gpu,
)
from tool0.batch.copy_sensor import CopySensor
from tool0.batch.saved import SavedCopy
from tool0.control.ros1.goal_check import INSTANT
from tool0.description.drive_limits import DriveLimits
from tool0.description.scene_state import ObjectState
from tool0.engines.mujoco.contact_arrays import (
    ContactArrays,
    are_touching,
    contact_arrays,
)
from tool0.engines.mujoco.copies import (
    ObjectArrays,
    ObjectReader,
    mujoco_engine,
    read_objects,
)
from tool0.errors import EngineError, GoalRejectedError
from tool0.kernel import library
from tool0.kernel.many import BatchKernel, StartResult
from tool0.kernel.memory import Addresses, IntArray
from tool0.kernel.motions import JointGoal
from tool0.kernel.program import Ended, TickProgram
from tool0.kinematics.chain import Array
from tool0.motion.gripper import direct_duration
from tool0.simulation.core import Core
from tool0.simulation.executor import Executor

MOST_TICKS = 1000
"""Largest number of ticks of each copy that the kernel executes per call; signals such
as Ctrl-C are handled between calls."""


@final
class Copies:
    """Cores of copies of one robot, with their state in the kernel's memory.

    While a copy is loaded into the kernel, its core is out of date; ``executor``
    updates the core.  Python runs the copies that the kernel cannot run, and the ticks
    that the kernel cannot execute.
    """

    def __init__(self, cores: Sequence[Core], threads: int) -> None:
        """Make copies from these cores; the kernel uses ``threads`` threads."""
        self._cores = tuple(cores)
        self._period = cores[0].control_period
        self._executors = tuple(map(Executor, cores))
        self._engines = [mujoco_engine(core.engine) for core in cores]
        n = len(cores)
        self._objects = ObjectReader(self._engines[0].world.states, n)
        self._n_joints = len(self._engines[0].joint_names)
        compiled = library.load()
        self._left, self._ticks, self._untold = np.zeros((3, n), dtype=np.int64)
        """Numbers of ticks of each copy: the ticks to execute, the ticks since the
        reset, and the ticks that the kernel has executed but the core has not yet
        counted."""
        self._kernel: BatchKernel | None = None
        if compiled is not None:
            counts = {"left": self._left, "ticks": self._ticks, "untold": self._untold}
            self._kernel = BatchKernel(compiled, threads, **counts)
        self._is_loaded = np.zeros(n, dtype=np.bool_)
        self._programs: list[TickProgram | None] = [None] * n
        self._has_diverged = np.zeros(n, dtype=np.bool_)
        self._last_steps: Addresses = np.zeros((n, 3), dtype=np.uintp)
        """Addresses of the last steps of copies that are loaded into the kernel; 0 for
        other copies."""
        self._sensors: list[CopySensor] = []
        self._laws: dict[int, Addresses] = {}
        """Addresses of the control laws of each running controller, by controller
        number."""

    @property
    def ticks(self) -> NDArray[np.int64]:
        """Number of control periods since the last reset of each copy."""
        return self._ticks

    @property
    def time(self) -> Array:
        """Simulated time since the last reset of each copy [s]."""
        return np.asarray(self._ticks * self._period)

    @property
    def has_diverged(self) -> NDArray[np.bool_]:
        """Whether each copy's physics has failed since its last ``reset``."""
        return self._has_diverged

    def step(self, ticks: int, rows: Indices) -> None:
        """Advance these copies, except those that have diverged."""
        left = self._left
        left[:] = 0
        left[rows] = ticks
        left[self._has_diverged] = 0
        while True:
            before = self._ticks.copy() if self._sensors else self._ticks
            others = self._load_left()
            is_open = self._kernel is not None and self._run(self._kernel)
            for i in others:
                left[i] -= self._tick(i, None, int(left[i]))
            for sensor in self._sensors:
                sensor.tick(self._ticks - before, self._last_steps)
            if not is_open and not others:
                return

    def _run(self, kernel: BatchKernel) -> bool:
        """Execute some or all remaining ticks in the kernel, and handle the results.

        Return whether ticks may remain.
        """
        most = kernel.most
        most[:] = MOST_TICKS
        for sensor in self._sensors:
            np.minimum(most, sensor.left, out=most, casting="same_kind")
        if not kernel.run():
            return False
        kernel.refresh(self._cores[0].hardware)
        for i in kernel.results.nonzero()[0].tolist():
            self._left[i] -= self._tick(i, Ended(kernel.results[i]), int(self._left[i]))
        return True

    def _load_left(self) -> list[int]:
        """Load the copies with remaining ticks.

        Return the copies that Python must execute.
        """
        if np.count_nonzero(self._is_loaded) == len(self._left):
            return []
        self.load(rows := self._left.nonzero()[0])
        others: list[int] = rows[~self._is_loaded[rows]].tolist()
        return others

    def _tick(self, i: int, event: Ended | None, left: int) -> int:
        """Execute a tick of one copy in Python.

        Return the decrease in the copy's remaining ticks.
        """
        core, untold = self._cores[i], int(self._untold[i])
        self._untold[i] = 0
        try:
            if event is None:
                core.tick()
            else:
                core.apply_kernel_result(event, untold)
        except EngineError:
            self._has_diverged[i] = True
            self._ticks[i] = core.ticks
            return left
        self._unload(i)
        self._ticks[i] = core.ticks
        return 1

    def load(self, rows: Indices) -> bool:
        """Load these copies into the kernel; return whether all are loaded."""
        is_loaded = self._is_loaded[rows]
        if np.count_nonzero(is_loaded) == len(rows):
            return True
        kernel = self._kernel
        if kernel is None:
            return False
        for i in rows[~is_loaded].tolist():
            program = self._cores[i].program()
            if program is None:
                continue
            self._is_loaded[i] = True
            self._programs[i] = program
            kernel.robots[i] = program.robot_address
            self._last_steps[i] = program.step_address
            for number in range(program.n_controllers):
                addresses = self._laws.setdefault(number, np.zeros_like(kernel.robots))
                addresses[i] = program.law_address(number)
        return bool(self._is_loaded[rows].all())

    def executor(self, i: int) -> Executor:
        """Return the executor of one copy after updating its core."""
        self.observed(i).sync_from_kernel()
        self._unload(i)
        return self._executors[i]

    def observed(self, i: int) -> Core:
        """Return the core of one copy with an up-to-date state, for reading only."""
        core, untold = self._cores[i], int(self._untold[i])
        if untold:
            self._untold[i] = 0
            core.apply_kernel_result(Ended.DONE, untold)
        return core

    def reset(self, rows: Indices, starts: Mapping[str, Array]) -> None:
        """Reset copies; see ``BatchBackend.reset``."""
        for row, i in enumerate(rows.tolist()):
            core = self._cores[i]
            core.sync_from_kernel()
            start = {name: float(values[row]) for name, values in starts.items()}
            core.reset(start, keep_time=False)
            self._unload(i)
            self._has_diverged[i] = False
            self._ticks[i] = self._untold[i] = 0
        for sensor in self._sensors:
            sensor.restart(rows)

    def save(self) -> tuple[SavedCopy, ...]:
        """Return the state of each copy; see ``BatchBackend.save``."""
        found = []
        for i, engine in enumerate(self._engines):
            core = self.observed(i).saved()
            self._unload(i)
            sensors = {sensor.kind: sensor.saved(i) for sensor in self._sensors}
            has_diverged = bool(self._has_diverged[i])
            found.append(SavedCopy(core, engine.saved(), has_diverged, sensors))
        return tuple(found)

    def restore(self, rows: Indices, saved: Sequence[SavedCopy]) -> None:
        """Restore saved states; see ``BatchBackend.restore``."""
        for state in saved:
            self._engines[0].check_saved(state.engine)
            self._cores[0].manager.check_saved(state.core.controllers)
        for i, state in zip(rows.tolist(), saved, strict=True):
            core, engine = self.observed(i), self._engines[i]
            core.resume(state.core)
            self._unload(i)
            engine.resume(state.engine)
            for item in state.engine.world.objects.values():
                core.scene.changed(item)
            self._has_diverged[i] = state.has_diverged
            self._ticks[i] = core.ticks
            for sensor in self._sensors:
                if sensor.kind in state.sensors:
                    sensor.resume(i, state.sensors[sensor.kind])
                else:
                    sensor.restart(rows[rows == i])

    def place(self, rows: Indices, name: str, position: Array, quat: Array) -> None:
        """Place an object; see ``BatchBackend.place``."""
        poses = zip(rows.tolist(), position.tolist(), quat.tolist(), strict=True)
        for i, (x, y, z), (qw, qx, qy, qz) in poses:
            state = ObjectState(name, (x, y, z), (qw, qx, qy, qz))
            self._cores[i].scene.place(state)

    def change(
        self, rows: Indices, name: str, field: ObjectField, values: Array
    ) -> None:
        """Change a field of an object; see ``BatchBackend.change``."""
        for i, value in zip(rows.tolist(), values.tolist(), strict=True):
            scene = self._cores[i].scene
            (item,) = (item for item in scene.objects if item.name == name)
            item = changed_object(item, field, value)
            self._engines[i].world.change(item)
            scene.changed(item)

    def _unload(self, i: int) -> None:
        self._is_loaded[i] = False
        self._last_steps[i] = 0
        self._programs[i] = None
        if self._kernel is not None:
            self._kernel.robots[i] = 0

    def states(self) -> tuple[Array, Array, Array]:
        """Return the positions, velocities and efforts, each of shape (n, n_joints)."""
        is_native = self._is_loaded & ~self._has_diverged
        if self._kernel is not None:
            found = self._kernel.read(is_native, self._n_joints)
        else:
            found = np.empty((3, len(is_native), self._n_joints))
        if np.count_nonzero(is_native) < len(is_native):
            for i in (~is_native).nonzero()[0].tolist():
                found[:, i] = self._cores[i].state[1:]
        position, velocity, effort = found
        return position, velocity, effort

    def objects(self) -> ObjectArrays:
        """Return the poses and velocities of the objects."""
        return read_objects(self._objects, self._engines)

    def pad_forces(self, pads: Sequence[str]) -> Array:
        """Return the normal force on each pad in the last step [N], (n, n_pads)."""
        return np.array([engine.world.normal_forces(pads) for engine in self._engines])

    def wrenches(self, links: frozenset[str], at: str) -> Array:
        """Return the wrench of contacts on ``links``; see ``BatchBackend.wrenches``."""
        return np.array([engine.world.wrench_on(links, at) for engine in self._engines])

    def contacts(self, first: Names | None, second: Names | None) -> ContactArrays:
        """Return the contacts; see ``BatchBackend.contacts``."""
        return contact_arrays([each.world for each in self._engines], first, second)

    def are_touching(self, first: Names, second: Names | None) -> NDArray[np.bool_]:
        """Return for each copy whether bodies touch.

        See ``BatchBackend.are_touching``.
        """
        return are_touching([each.world for each in self._engines], first, second)

    def start_sensor(self, sensor: CopySensor) -> None:
        """Take a sample in all copies now, and more samples whenever they are due."""
        for i in range(len(self._cores)):
            self.executor(i)  # updates the copy's core
        sensor.restart(np.arange(len(self._cores)))
        self._sensors.append(sensor)

    def stop_sensor(self, sensor: CopySensor) -> None:
        """Stop the sampling of a sensor."""
        self._sensors.remove(sensor)

    # ---- commands to copies that are loaded ----------------------------------------

    def start(
        self,
        rows: Indices,
        controller: int,
        joints: IntArray,
        *,
        times: Array,
        positions: Array,
        velocities: Array | None,
        lifts_limits: bool,
    ) -> bool:
        """Start motions, in the kernel if possible; see ``BatchBackend.start``.

        Raises:
            GoalRejectedError: If the joints cannot make this motion, in which case the
                copies are unchanged.
        """
        if lifts_limits or min(times[:, 0].tolist(), default=1.0) <= 2.0 * INSTANT:
            return False
        if self._kernel is None or not self.load(rows):
            return False
        started, which = self._kernel.start(
            chosen(self._kernel.robots, rows),
            chosen(self._laws[controller], rows),
            joints,
            now=chosen(self.time, rows),
            times=times,
            positions=positions,
            velocities=velocities,
        )
        if started is StartResult.REFUSED:
            raise GoalRejectedError(
                f"copy {rows[which]}: no joint can move through "
                f"{positions[which].tolist()} within {times[which, -1]:.6g} s"
            )
        return started is StartResult.YES

    def arrays(self) -> DeviceArrays:
        """Raise ControlError, because there is no device."""
        raise needs_gpu("Batch.device_arrays")

    def holds(self, array: object) -> bool:
        """Return False, because every array is in the host's memory."""
        return False

    def command(
        self,
        rows: Indices,
        goals: Mapping[int, Sequence[JointGoal]],
        positions: object,
        velocities: object | None,
        duration: float,
    ) -> None:
        """Raise ControlError, because there is no device."""
        raise needs_gpu("Batch.command with an array on a device")

    def grip(
        self,
        rows: Indices,
        controller: int,
        joint: int,
        openings: object,
        limits: Sequence[DriveLimits],
    ) -> bool:
        """Move a gripper, in the kernel if possible; see ``BatchBackend.grip``."""
        if self._kernel is None or not self.load(rows):
            return False
        laws = chosen(self._laws[controller], rows)
        here = self._kernel.desired(laws, joint, chosen(self.time, rows))
        if here is None:
            return False
        ends = chosen(np.asarray(openings), rows).tolist()
        gripper, period = limits[0].gripper, self._period
        durations = [
            direct_duration(gripper, at, end, each.speed or gripper.speed[1], period)
            for each, at, end in zip(limits, here.tolist(), ends, strict=True)
        ]
        targets = np.array(list(map(gripper.position, ends)))[:, None, None]
        has_started = self.start(
            rows,
            controller,
            np.array([joint], np.int32),
            times=np.array(durations)[:, None],
            positions=targets,
            velocities=np.zeros_like(targets),
            lifts_limits=False,
        )
        if has_started:
            self._limit_drives(rows, limits)
        return has_started

    def drive(
        self,
        rows: Indices,
        controller: int,
        targets: Sequence[float],
        effort: float | None,
        limits: Sequence[DriveLimits],
    ) -> bool:
        """Start goals of a gripper in the kernel's memory; see ``BatchBackend.drive``.

        No handles are returned for these goals.
        """
        if self._kernel is None or not self.load(rows):
            return False
        now = self.time[rows].tolist()
        for i, target, time, bound in zip(
            rows.tolist(), targets, now, limits, strict=True
        ):
            program = self._programs[i]
            assert program is not None
            program.start_grip(controller, target, effort, bound, time)
        self._limit_drives(rows, limits)
        return True

    def _limit_drives(self, rows: Indices, limits: Sequence[DriveLimits]) -> None:
        """Limit the drive of a gripper in copies that are loaded into the kernel."""
        driven = self._engines[0].joint_names.index(limits[0].gripper.joint)
        for i, each in zip(rows.tolist(), limits, strict=True):
            program = self._programs[i]
            assert program is not None
            program.set_drive_limits(driven, each)
