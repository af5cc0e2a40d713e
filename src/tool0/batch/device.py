"""The copies of a batch on a GPU."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NoReturn, final

import numpy as np
from numpy.typing import NDArray

from tool0.batch.arguments import Indices
from tool0.batch.backend import DeviceArrays, Names, ObjectField, needs_cpu
from tool0.batch.copy_sensor import CopySensor
from tool0.description.drive_limits import DriveLimits
from tool0.description.forward_kinematics import joint_position
from tool0.description.model import RobotModel
from tool0.engines.mujoco.copies import ObjectArrays, mujoco_engine
from tool0.engines.mujoco.warp_worlds import WarpWorlds, check_device
from tool0.errors import GoalRejectedError
from tool0.kernel.device import DeviceControl, DeviceState, is_on_device
from tool0.kernel.memory import IntArray
from tool0.kernel.motions import JointGoal
from tool0.kinematics.chain import Array
from tool0.simulation.core import Core
from tool0.simulation.executor import Executor


@final
class DeviceCopies:
    """Copies of one core, with their state, controllers and drives on a Warp device."""

    def __init__(self, core: Core, model: RobotModel, n: int, device: str) -> None:
        """Copy the state of ``core``, which is never stepped.

        Raises:
            ConfigError: If the device cannot run a controller.
            EngineError: If there is no such device, or the device cannot simulate the
                scene.
        """
        name = check_device(device)
        self._device, self._name = device, name
        engine = mujoco_engine(core.engine)
        self._model, self._dt = model, engine.dt
        self._period = core.control_period
        self._steps_per_tick = round(core.control_period / engine.dt)
        self._n = n
        self._initial = np.tile(core.state.position, (n, 1))
        self._worlds = worlds = WarpWorlds(engine, n, name)
        statuses = core.manager.list()
        names = [each.name for each in statuses if each.is_running]
        self._control = DeviceControl(
            dict(zip(names, core.manager.running_controllers, strict=True)),
            core.hardware,
            model.grippers,
            DeviceState(
                worlds.steps,
                worlds.position,
                worlds.velocity,
                worlds.motors,
                worlds.divergence,
            ),
            position=self._initial,
            motor_joints=engine.motor_joints(),
            period=core.control_period,
            device=name,
        )
        self._launch: Callable[[], None] | None = None
        """Recorded launch of one tick; None until it is recorded."""
        self._layout = self._control.layout

    @property
    def time(self) -> Array:
        """Simulated time since the last reset of each copy [s]."""
        ticks = self._worlds.steps.numpy() // self._steps_per_tick
        return np.asarray(ticks * self._period)

    @property
    def has_diverged(self) -> NDArray[np.bool_]:
        """Whether each copy's physics has failed since its last ``reset``."""
        return self._worlds.has_diverged

    def step(self, ticks: int, rows: Indices) -> None:
        """Advance the copies that have not diverged.

        ``rows`` must contain all copies.
        """
        self._control.upload()
        if self._layout != self._control.layout:
            self._launch, self._layout = None, self._control.layout
        for _ in range(ticks):
            if self._launch is None:
                self._tick()  # compiles the kernels
                self._launch = self._worlds.recorded(self._tick)
            else:
                self._launch()

    def _tick(self) -> None:
        self._control.launch_laws()
        for _ in range(self._steps_per_tick):
            self._control.launch_drives()
            self._worlds.step()

    def reset(self, rows: Indices, starts: Mapping[str, Array]) -> None:
        """Reset copies; see ``BatchBackend.reset``."""
        if not rows.size:
            return
        joints = self._model.movable_joints
        q = {joint.name: self._initial[rows, k] for k, joint in enumerate(joints)}
        q.update(starts)
        free = {joint.name: q[joint.name] for joint in joints if joint.mimic is None}
        columns = [joint_position(joint, free) for joint in joints]
        position = np.stack(columns, axis=1)
        self._worlds.reset(rows, position)
        self._control.restart(rows, position)

    def save(self) -> NoReturn:
        """Raise ControlError, because the copies have no cores."""
        raise needs_cpu("Batch.save", self._device)

    def restore(self, rows: Indices, saved: Sequence[object]) -> NoReturn:
        """Raise ControlError, because the copies have no cores."""
        raise needs_cpu("Batch.restore", self._device)

    def states(self) -> tuple[Array, Array, Array]:
        """Return the positions, velocities and efforts, each of shape (n, n_joints)."""
        return (*self._worlds.joints(), self._control.effort)

    def arrays(self) -> DeviceArrays:
        """Return the state on the device."""
        worlds = self._worlds
        return DeviceArrays(
            *worlds.joint_arrays,
            self._control.effort_array,
            *worlds.object_arrays,
            worlds.divergence,
        )

    def objects(self) -> ObjectArrays:
        """Return the poses and velocities of the objects."""
        return self._worlds.objects()

    def pad_forces(self, pads: Sequence[str]) -> Array:
        """Return the normal force on each pad in the last step [N], (n, n_pads)."""
        return self._worlds.normal_forces(pads)

    def wrenches(self, links: frozenset[str], at: str) -> NoReturn:
        """Raise ControlError, because contacts on a device have no torques."""
        raise needs_cpu("Batch.tool_wrench", self._device)

    def contacts(self, first: Names | None, second: Names | None) -> NoReturn:
        """Raise ControlError, because contacts on a device have no torques."""
        raise needs_cpu("Batch.contacts", self._device)

    def are_touching(self, first: Names, second: Names | None) -> NDArray[np.bool_]:
        """Return for each copy whether bodies touch.

        See ``BatchBackend.are_touching``.
        """
        return self._worlds.are_touching(first, second)

    def start_sensor(self, sensor: CopySensor) -> NoReturn:
        """Raise ControlError, because contacts on a device have no torques."""
        raise needs_cpu("Batch.force_torque", self._device)

    def stop_sensor(self, sensor: CopySensor) -> None:
        """Do nothing, because a device has no sensors."""

    def place(self, rows: Indices, name: str, position: Array, quat: Array) -> None:
        """Place an object at positions [m] with quat_wxyz; see ``BatchBackend.place``.

        Raises:
            ControlError: If the object is fixed.
        """
        self._worlds.place(name, rows, position, quat)

    def change(
        self, rows: Indices, name: str, field: ObjectField, values: Array
    ) -> None:
        """Change a field of an object; see ``BatchBackend.change``.

        Raises:
            ControlError: If the field is the size, because all copies on a device have
                the same shapes.
        """
        if field == "size":
            raise needs_cpu("Batch.set_size", self._device)
        if field == "mass":
            self._worlds.set_mass(name, rows, values)
        else:
            self._worlds.set_friction(name, rows, values)

    # ---- commands -------------------------------------------------------------------

    def executor(self, i: int) -> Executor:
        """Raise ControlError, because the copies have no cores."""
        raise needs_cpu(f"what moves copy {i}", self._device)

    def start(
        self,
        rows: Indices,
        controller: int,
        joints: IntArray,
        *,
        times: Array,
        positions: Array,
        velocities: Array | None,
        lifts_limits: bool,  # ignored: the limits are always removed
    ) -> bool:
        """Start motions and return True; see ``BatchBackend.start``.

        Raises:
            GoalRejectedError: If the joints cannot make this motion, in which case the
                copies are unchanged.
        """
        refused = self._control.start(
            rows,
            controller,
            joints.tolist(),
            now=self.time[rows],
            times=times,
            positions=positions,
            velocities=velocities,
        )
        if refused is not None:
            raise GoalRejectedError(
                f"copy {rows[refused]}: no joint can move through "
                f"{positions[refused].tolist()} within {times[refused, -1]:.6g} s"
            )
        return True

    def holds(self, array: object) -> bool:
        """Return whether an array, unlike a NumPy array, is in the device's memory."""
        return not isinstance(array, np.ndarray) and is_on_device(array, self._name)

    def command(
        self,
        rows: Indices,
        goals: Mapping[int, Sequence[JointGoal]],
        positions: object,
        velocities: object | None,
        duration: float,
    ) -> None:
        """Start motions to positions on the device; see ``BatchBackend.command``."""
        for controller, its in goals.items():
            self._control.command(
                rows,
                controller,
                its,
                positions=positions,
                velocities=velocities,
                duration=duration,
            )

    def grip(
        self,
        rows: Indices,
        controller: int,
        joint: int,
        openings: object,
        limits: Sequence[DriveLimits],
    ) -> bool:
        """Move a gripper and return True; see ``BatchBackend.grip``."""
        speeds, forces = np.zeros((2, self._n))
        speeds[rows] = [each.speed for each in limits]
        forces[rows] = [each.force for each in limits]
        self._control.grip(
            rows,
            controller,
            joint,
            limits[0].gripper,
            openings=openings,
            speeds=speeds,
            forces=forces,
        )
        return True

    def drive(
        self,
        rows: Indices,
        controller: int,
        targets: Sequence[float],
        effort: float | None,
        limits: Sequence[DriveLimits],
    ) -> bool:
        """Return False, because GripperActionControllers run only on the CPU."""
        return False
