"""Controllers and drives of many robots on a Warp device, in single precision."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from typing import Any, NamedTuple, final

import numpy as np
import warp as wp

from tool0.control.controller import Controller
from tool0.control.law import IdleLaw, TrajectoryLaw
from tool0.description.model import LinearOpening, ParallelGripper, RotaryOpening
from tool0.errors import ConfigError, ControlError
from tool0.hardware.limits import DriveBounds
from tool0.hardware.robot_hardware import POSE_PERIOD, RobotHardware
from tool0.kernel.device_governor import DeviceGovernor, body_structs
from tool0.kernel.motions import Array, Indices, JointGoal, Motions
from tool0.kernel.warp_laws import (
    Body,
    Drive,
    Goal,
    Gripper,
    Spring,
    balance,
    restart,
    run_drives,
    run_laws,
    start_grips,
    start_motions,
)
from tool0.motion.gripper import RAMP_TIME

NO_GRIP = (0.0, 0.0, 0.0)
DLPACK_CPU, DLPACK_CUDA = 1, 2
"""Device types in the result of ``__dlpack_device__``."""


class DeviceState(NamedTuple):
    """Arrays of the engine on the device, with one row per robot.

    If an array has more columns than joints, the columns of the joints come first.
    """

    steps: Any
    """Number of physics steps since the reset, shape (n,)."""
    position: Any
    velocity: Any
    motors: Any
    """Efforts that the engine reads, with one column per motor."""
    has_diverged: Any
    """Value 1 for each robot that was stopped because it diverged, shape (n,)."""


@final
class DeviceControl:
    """The running controllers and the drives of n copies of one robot.

    Arguments and results that are arrays have double precision.
    """

    def __init__(
        self,
        running: Mapping[str, tuple[Controller, Sequence[int]]],
        hardware: RobotHardware,
        grippers: Sequence[ParallelGripper],
        state: DeviceState,
        *,
        position: Array,
        motor_joints: Sequence[int],
        period: float,
        device: str,
    ) -> None:
        """Start with all copies at rest.

        Args:
            running: The running controllers and their joints by controller name, in
                load order.
            hardware: The drives.
            grippers: Grippers for which goals with limits can be started.
            state: State of the engine.
            position: Positions of the joints [rad | m], shape (n, n_joints).
            motor_joints: Number of the joint of each motor.
            period: Length of a tick [s].
            device: Warp's name of the device.

        Raises:
            ConfigError: If the device cannot run a controller or a drive.
        """
        laws = _laws(running, hardware)
        self._state, self._device = state, device
        self._dt, self._period = hardware.table.dt, period
        n = len(position)
        self._first: list[int] = []
        """Index of each running controller's first joint among the controlled
        joints."""
        joints: list[int] = []
        for (_, its), law in zip(running.values(), laws, strict=True):
            self._first.append(len(joints))
            joints += its if law is not None else ()
        self._joints = joints
        wraps, gains, feed_forward = _constants(laws)
        self._motions = Motions(position[:, joints], wraps)
        self._motions.extend(2)  # number of pieces that ``command`` needs
        self._is_uploaded = self._is_ahead = False
        table = hardware.table
        self._drives = [bounds.joint for bounds in table.bounds]
        self._grips = np.zeros((n, len(self._drives), 3), dtype=np.float32)
        compensated = [float(i in table.compensated) for i in self._drives]
        n_joints, n_bodies = len(hardware.joint_names), len(table.dynamics.bodies)
        governed = {each.joint for each in hardware.setup.governor.drives}
        pads = {gripper.joint: gripper for gripper in grippers}
        names = hardware.joint_names
        with wp.ScopedDevice(device):
            self._joint_array = wp.array(joints, dtype=int)
            self._wraps = wp.array([int(wrap) for wrap in wraps], dtype=int)
            self._gains = wp.array(gains, dtype=float, ndim=2)
            self._feed_forward = wp.array(feed_forward, dtype=float)
            self._integrals = wp.zeros((n, len(joints)), dtype=float)
            self._command = wp.zeros((n, n_joints), dtype=float)
            self._effort = wp.zeros((n, n_joints), dtype=float)
            self._loads = wp.zeros((n, n_joints), dtype=float)
            self._before = wp.full((n, len(self._drives)), math.nan, dtype=float)
            self._bodies = wp.array(
                body_structs(table.dynamics.bodies, table.to_model), dtype=Body
            )
            self._governor = DeviceGovernor(hardware, n)
            self._springs = wp.array(_springs(hardware), dtype=Spring)
            self._drive_table = wp.array(
                [
                    _drive(bounds, pads.get(names[bounds.joint]), governed)
                    for bounds in table.bounds
                ],
                dtype=Drive,
            )
            self._compensates = wp.array(compensated, dtype=float)
            motors = [motor_joints.index(i) for i in self._drives]
            self._motor_of = wp.array(motors, dtype=int)
            self._rotations = wp.zeros((n, n_bodies), dtype=wp.mat33)
            self._positions = wp.zeros((n, n_bodies), dtype=wp.vec3)
            self._moments = wp.zeros((n, n_bodies), dtype=wp.vec3)
            self._grip_array = wp.zeros((n, len(self._drives)), dtype=wp.vec3)
        self._gravity = table.dynamics.gravity
        self.layout = 0
        """Counter that is incremented when arrays are reallocated.  A reallocation
        invalidates recorded graphs."""
        self._allocate()

    @property
    def effort(self) -> Array:
        """Efforts that were applied in the last step [N·m | N], shape (n, n_joints)."""
        return np.asarray(self._effort.numpy(), dtype=np.float64)

    @property
    def effort_array(self) -> Any:
        """Efforts that were applied in the last step [N·m | N], as a Warp array."""
        return self._effort

    # ---- launches in a tick ---------------------------------------------------------

    def upload(self) -> None:
        """Copy the commands to the device if they have changed."""
        if self._is_uploaded:
            return
        if self._until.shape != self._motions.until.shape:
            self._allocate()
        motions = self._motions
        self._until.assign(motions.until)
        self._origin.assign(motions.origin)
        self._coefficients.assign(motions.coefficients.astype(np.float32))
        self._grip_array.assign(self._grips)
        self._is_uploaded = True

    def _download(self) -> None:
        """Copy to the host the motions that were started on the device."""
        if self._is_ahead:
            motions = self._motions
            motions.until = self._until.numpy().copy()
            motions.origin = self._origin.numpy().copy()
            coefficients = self._coefficients.numpy()
            motions.coefficients = coefficients.astype(np.float64)
            self._grips = self._grip_array.numpy().copy()
            self._is_ahead = False

    def _allocate(self) -> None:
        self.layout += 1
        shape = self._motions.until.shape
        with wp.ScopedDevice(self._device):
            self._until = wp.zeros(shape, dtype=wp.float64)
            self._origin = wp.zeros(shape, dtype=wp.float64)
            self._coefficients = wp.zeros(shape, dtype=wp.vec4)

    def launch_laws(self) -> None:
        """Launch the computation of the commands of a tick."""
        state = self._state
        wp.launch(
            run_laws,
            dim=self._integrals.shape,
            inputs=[
                state.steps,
                self._dt,
                self._period,
                self._joint_array,
                self._wraps,
                self._gains,
                self._feed_forward,
                self._until,
                self._origin,
                self._coefficients,
                state.position,
                state.velocity,
                self._integrals,
                self._command,
            ],
            device=self._device,
        )

    def launch_drives(self) -> None:
        """Launch the computation of the motors' efforts for the next step."""
        state = self._state
        wp.launch(
            balance,
            dim=self._integrals.shape[0],
            inputs=[
                state.steps,
                POSE_PERIOD,
                self._gravity,
                self._bodies,
                self._springs,
                state.position,
                self._rotations,
                self._positions,
                self._moments,
                self._loads,
            ],
            device=self._device,
        )
        requested = self._governor.launch(
            self._command, self._loads, state.position, state.velocity, self._effort
        )
        wp.launch(
            run_drives,
            dim=self._before.shape,
            inputs=[
                self._drive_table,
                self._compensates,
                self._loads,
                self._grip_array,
                requested,
                state.position,
                state.velocity,
                self._before,
                self._effort,
                state.motors,
                self._motor_of,
            ],
            device=self._device,
        )

    # ---- commands between ticks -----------------------------------------------------

    def restart(self, rows: Indices, position: Array) -> None:
        """Set copies to rest with all joints at ``position``, (len(rows), n_joints)."""
        self._download()
        self._motions.rest(rows, position[:, self._joints])
        self._grips[rows] = NO_GRIP
        self._is_uploaded = False
        wp.launch(
            restart,
            dim=len(self._grips),
            inputs=[
                self._chosen(rows),
                self._integrals,
                self._command,
                self._before,
                self._effort,
                *self._governor.flags,
            ],
            device=self._device,
        )

    def start(
        self,
        rows: Indices,
        controller: int,
        joints: Sequence[int],
        *,
        now: Array,
        times: Array,
        positions: Array,
        velocities: Array | None,
    ) -> int | None:
        """Start motions as ``Motions.start`` does, without limits of earlier goals."""
        self._download()
        columns = [self._first[controller] + joint for joint in joints]
        refused = self._motions.start(
            rows,
            columns,
            now=now,
            times=times,
            positions=positions,
            velocities=velocities,
        )
        if refused is not None:
            return refused
        for column in columns:
            self._grips[rows, self._drive_of(column)] = NO_GRIP
        self._is_uploaded = False
        return None

    def command(
        self,
        rows: Indices,
        controller: int,
        goals: Sequence[JointGoal],
        *,
        positions: object,
        velocities: object | None,
        duration: float,
    ) -> None:
        """Start motions to positions in arrays on the device, shape (n, k).

        The effect is that of ``start`` with one point; limits of earlier goals no
        longer apply.  Positions beyond the limits are clamped.  A robot with a number
        that is not finite is marked as diverged.

        Raises:
            ControlError: If an array does not have single precision.
        """
        self.upload()
        structs = []
        for each in goals:
            goal = Goal()
            goal.source, goal.lower, goal.upper = each.source, each.lower, each.upper
            goal.column = self._first[controller] + each.joint
            goal.drive = self._drive_of(goal.column)
            structs.append(goal)
        none = wp.zeros((0, 0), dtype=float, device=self._device)
        wp.launch(
            start_motions,
            dim=(len(self._grips), len(goals)),
            inputs=[
                self._chosen(rows),
                self._state.steps,
                self._dt,
                duration,
                wp.array(structs, dtype=Goal, device=self._device),
                self._wraps,
                _floats(positions),
                none if velocities is None else _floats(velocities),
                self._until,
                self._origin,
                self._coefficients,
                self._grip_array,
                self._state.has_diverged,
            ],
            device=self._device,
        )
        self._is_ahead = True

    def grip(
        self,
        rows: Indices,
        controller: int,
        joint: int,
        gripper: ParallelGripper,
        *,
        openings: object,
        speeds: Array,
        forces: Array,
    ) -> None:
        """Move pads to openings [m] with speeds [m/s] and forces [N], shape (n,).

        ``openings`` may be an array on the device.  Openings out of range are clamped.
        A robot with an opening that is not finite is marked as diverged.

        Args:
            rows: The robots.
            controller: Number of the running controller.
            joint: Number of the gripper's joint in this controller.
            gripper: Geometry of the gripper.
            openings: Distances between the pads.
            speeds: Largest speeds of the pads relative to each other.
            forces: Largest forces at each pad.
        """
        self.upload()
        column = self._first[controller] + joint
        found = Gripper()
        found.column, found.drive = column, self._drive_of(column)
        found.widest, found.fastest = gripper.max_opening, gripper.speed[1]
        found.ramp_time, found.shortest = RAMP_TIME, self._period
        found.pad_offset = gripper.law.pad_offset
        match gripper.law:
            case LinearOpening() as law:
                found.is_linear, found.pad_slope = 1, law.pad_slope
            case RotaryOpening() as law:
                found.pad_cos, found.pad_sin = law.pad_cos, law.pad_sin
        if isinstance(openings, np.ndarray):
            openings = wp.array(openings, dtype=float, device=self._device)
        wp.launch(
            start_grips,
            dim=len(self._grips),
            inputs=[
                self._chosen(rows),
                self._state.steps,
                self._dt,
                found,
                _floats(openings),
                wp.array(speeds, dtype=float, device=self._device),
                wp.array(forces, dtype=float, device=self._device),
                self._until,
                self._origin,
                self._coefficients,
                self._grip_array,
                self._state.has_diverged,
            ],
            device=self._device,
        )
        self._is_ahead = True

    def _drive_of(self, column: int) -> int:
        """Return the number of the drive for a controlled joint."""
        return self._drives.index(self._joints[column])

    def _chosen(self, rows: Indices) -> Any:
        mask = np.zeros(len(self._grips), dtype=np.int32)
        mask[rows] = 1
        return wp.array(mask, dtype=int, device=self._device)


def is_on_device(array: object, device: str) -> bool:
    """Return whether another library's array is in the memory of a device."""
    if not hasattr(array, "__dlpack_device__"):
        return False
    kind, number = array.__dlpack_device__()
    known = wp.get_device(device)
    if known.is_cuda:
        return bool(kind == DLPACK_CUDA and number == known.ordinal)
    return bool(kind == DLPACK_CPU)


def _floats(array: object) -> Any:
    """Return an array on the device as a Warp array that shares its memory."""
    found = array if isinstance(array, wp.array) else wp.from_dlpack(array)
    if found.dtype is not wp.float32:
        raise ControlError(
            f"an array on the device must be float32, got {found.dtype.__name__}"
        )
    return found


def _laws(
    running: Mapping[str, tuple[Controller, Sequence[int]]], hardware: RobotHardware
) -> list[TrajectoryLaw | None]:
    """Return each controller's law, or None for an idle controller.

    Raises:
        ConfigError: If a controller, a servo or a brake cannot run on a GPU.
    """
    laws: list[TrajectoryLaw | None] = []
    for name, (controller, _) in running.items():
        law = controller.law()
        if isinstance(law, IdleLaw):
            laws.append(None)
        elif isinstance(law, TrajectoryLaw) and law.pid and not law.lead:
            laws.append(law)
        else:
            raise ConfigError(
                f"controller '{name}' cannot run on a GPU; only ROS 1's Joint"
                "TrajectoryControllers with an effort interface can: use device='cpu'"
            )
    setup = hardware.setup
    held = [*(i for i, _ in setup.servos), *setup.brakes]
    if held:
        joints = [hardware.joint_names[i] for i in sorted(held)]
        raise ConfigError(
            f"the servos and brakes of {', '.join(joints)} cannot run on a GPU; only "
            "joints with a running effort controller can: use device='cpu'"
        )
    return laws


def _constants(
    laws: Sequence[TrajectoryLaw | None],
) -> tuple[list[bool], list[tuple[float, ...]], list[float]]:
    """Return, for each joint: whether errors wrap, the gains, and the feed-forward."""
    wraps: list[bool] = []
    gains: list[tuple[float, ...]] = []
    feed_forward: list[float] = []
    for law in laws:
        if law is not None and law.pid is not None:
            rows = [tuple(map(float, row[1:7])) for row in law.pid.rows]
            wraps += [k in law.wrapping for k in range(len(rows))]
            gains += rows
            feed_forward += law.feed_forward or [0.0] * len(rows)
    return wraps, gains, feed_forward


def _springs(hardware: RobotHardware) -> list[Any]:
    table = hardware.table
    found = []
    for each in table.dynamics.springs:
        spring = Spring()
        spring.joint = table.to_model[each.joint]
        spring.master = table.to_model[each.master]
        spring.factor = each.multiplier * each.stiffness
        spring.reference = each.reference
        found.append(spring)
    return found


def _drive(
    bounds: DriveBounds, gripper: ParallelGripper | None, governed: Set[int]
) -> Any:
    drive = Drive()
    drive.is_governed = int(bounds.joint in governed)
    for name in ("joint", "effort", "velocity", "lower", "upper", "rotor", "ease"):
        setattr(drive, name, getattr(bounds, name))
    if bounds.soft is not None:
        drive.is_soft, drive.k_velocity = 1, bounds.soft.k_velocity
        drive.k_position = bounds.soft.k_position
        drive.soft_lower = bounds.soft.soft_lower_limit
        drive.soft_upper = bounds.soft.soft_upper_limit
    match gripper and gripper.law:
        case LinearOpening() as law:
            drive.is_linear, drive.pad_slope = 1, law.pad_slope
        case RotaryOpening() as law:
            drive.pad_cos, drive.pad_sin = law.pad_cos, law.pad_sin
    return drive
