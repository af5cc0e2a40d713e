"""Execution of the ticks of one robot by the kernel, up to the next event."""

from __future__ import annotations

import math
from collections.abc import Sequence
from ctypes import CDLL, addressof, byref, c_int, sizeof
from enum import IntEnum
from typing import final

import numpy as np

from tool0.control.controller import (
    Controller,
    ControllerSpec,
    GripperDriver,
    TrajectoryFollower,
)
from tool0.control.law import (
    ActiveLaw,
    CommandLaw,
    GripperLaw,
    IdleLaw,
    Law,
    TrajectoryLaw,
)
from tool0.control.sampler import GoalMonitor, pieces_from
from tool0.control.trajectory_monitor import TrajectoryMonitor
from tool0.description.drive_limits import DriveLimits
from tool0.hardware.engine import BRAKE_STANDSTILL, JointState, NativeStepper
from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.drives import NativeDrives, goal_limits
from tool0.kernel.masses import refresh_masses, refresh_mobilities
from tool0.kernel.memory import (
    GRIP_FIELDS,
    FloatArray,
    LawMemory,
    LawStruct,
    RobotStruct,
    packed,
    tolerance_rows,
)

LOADED_PIECES = 16
"""Number of pieces of a motion that Python loads for each joint at a time."""


@final
class RobotMemory:
    """Memory of one robot, which contains its struct and the state between ticks."""

    def __init__(self, n_joints: int, n_laws: int) -> None:
        self.laws = (LawStruct * n_laws)()
        self.command: FloatArray = np.zeros(n_joints)
        self.effort: FloatArray = np.zeros(n_joints)
        self._tick: FloatArray = np.zeros((3, n_joints))
        self._step: FloatArray = np.zeros((3, n_joints))
        self.struct = struct = RobotStruct(n_joints=n_joints, n_laws=n_laws)
        struct.laws = addressof(self.laws)
        struct.command = self.command.ctypes.data
        struct.effort = self.effort.ctypes.data
        for at, rows in (("tick", self._tick), ("step", self._step)):
            for row, name in zip(rows, ("position", "velocity", "effort"), strict=True):
                setattr(struct, f"{at}_{name}", row.ctypes.data)

    def set_stepper(self, stepper: NativeStepper) -> None:
        """Set the engine that is stepped."""
        self._motor_joints = np.array(stepper.motor_joints, dtype=np.int32)
        struct = self.struct
        struct.step, struct.on_error = stepper.step, stepper.on_error
        struct.clock = stepper.clock
        struct.model = stepper.model
        struct.data = stepper.data
        struct.position, struct.velocity = stepper.position, stepper.velocity
        struct.n_velocities, struct.motors = stepper.n_velocities, stepper.motors
        struct.n_motors = len(self._motor_joints)
        struct.motor_joints = self._motor_joints.ctypes.data
        self._brakes = np.array(stepper.brakes, dtype=np.int32)
        struct.n_brakes, struct.brakes = len(self._brakes), self._brakes.ctypes.data
        struct.standstill = BRAKE_STANDSTILL

    def tick_start(self) -> JointState:
        """Return the state at the start of the last tick or of the unfinished tick."""
        struct = self.struct
        steps = struct.steps - struct.steps_per_tick + struct.steps_left
        position, velocity, effort = self._tick.tolist()
        return JointState(steps * struct.dt, position, velocity, effort)

    def step_start(self) -> JointState:
        """Return the state at the start of the last step."""
        struct = self.struct
        position, velocity, effort = self._step.tolist()
        return JointState((struct.steps - 1) * struct.dt, position, velocity, effort)


@final
class _LoadedLaw:
    """Law of a running controller in the kernel's memory."""

    def __init__(self, law: ActiveLaw, joints: Sequence[int]) -> None:
        self._memory = LawMemory(law, joints)
        self._struct = LawStruct()
        self._law = law
        self._rows = law.pid and law.pid.rows
        self._packed: tuple[object, object] | None = None
        self._known_until = -math.inf
        self._started_grip: tuple[DriveLimits, float] | None = None
        """Limits and start time [s] of a goal that has not been passed to Python
        yet."""

    def use(self, struct: LawStruct) -> None:
        """Use ``struct``, which must be new and empty, for the law."""
        self._struct = struct
        self._memory.fill(struct, self._law)

    def load(self, law: ActiveLaw, time: float) -> None:
        """Copy the law's state at ``time`` [s] to the kernel's memory."""
        memory, pid = self._memory, law.pid
        self._law = law
        if pid is not None:
            if pid.rows is not self._rows:
                self._rows = pid.rows
                memory.gains[:] = [row[1:] for row in pid.rows]
            memory.integrals[:] = pid.integrals
        if isinstance(law, TrajectoryLaw):
            self._load_motion(law, time)
        elif isinstance(law, GripperLaw):
            self._load_grip(law)
        else:
            memory.values[:] = law.values
            memory.last_errors[:] = law.last_errors

    def _load_motion(self, law: TrajectoryLaw, time: float) -> None:
        memory, struct, monitor = self._memory, self._struct, law.monitor
        if memory.start is not None:
            memory.start.load(law.start, has_points=law.has_points)
        motion = law.sampler, monitor
        struct.lead = law.lead
        struct.since, struct.lag, struct.slip = law.clock
        time = law.clock.at(time)
        if motion != self._packed or time + law.lead >= self._known_until:
            self._packed, self._known_until = motion, math.inf
            checked = monitor if isinstance(monitor, GoalMonitor) else None
            for k, spline in enumerate(law.sampler.splines):
                pieces = pieces_from(spline, time, LOADED_PIECES)
                memory.pieces[k, : len(pieces)] = [
                    packed(piece, checked) for piece in pieces
                ]
                memory.n_pieces[k] = len(pieces)
                self._known_until = min(self._known_until, pieces[-1].until)
            memory.piece[:] = memory.piece_ahead[:] = 0
            struct.next_change = struct.next_change_ahead = -math.inf
            if isinstance(monitor, TrajectoryMonitor):
                self._check_all(monitor)
        struct.is_monitored = monitor is not None
        if isinstance(monitor, GoalMonitor):
            struct.goal_time = monitor.goal_time
            memory.arrived[:] = 0
            memory.arrived[list(monitor.arrived)] = 1

    def _check_all(self, monitor: TrajectoryMonitor) -> None:
        struct = self._struct
        struct.watches_all, struct.has_goal = True, monitor.goal is not None
        struct.end, struct.timeout = monitor.end, monitor.timeout
        struct.goal_time = monitor.goal_time
        self._memory.tolerances[:] = tolerance_rows(monitor.path, monitor.at_goal)

    def _load_grip(self, law: GripperLaw) -> None:
        grip = law.grip
        values = (
            *(law.target, law.tolerance, law.max_effort),
            *(law.stall_range, law.stall_timeout, grip.ramp, grip.effort),
            *(grip.stall_position, grip.stall_since, law.position, False),
        )
        for name, value in zip(GRIP_FIELDS, values, strict=True):
            setattr(self._memory.grip, name, value)
        self._struct.is_monitored = law.has_goal
        self._bound_grip(law.drive_limits)

    def _bound_grip(self, limits: DriveLimits | None) -> None:
        self._struct.bounds = 0
        if limits is not None:
            self._bounds = goal_limits(limits)
            self._struct.bounds = addressof(self._bounds)

    def start_grip(
        self, target: float, effort: float | None, limits: DriveLimits, now: float
    ) -> None:
        """Start a goal without a handle, as ``GripperActionController.drive`` does."""
        law, grip = self._law, self._memory.grip
        assert isinstance(law, GripperLaw)
        self._started_grip = limits, now
        lead, distance = grip.ramp - grip.position, target - grip.position
        if lead * distance <= 0.0:
            grip.ramp = grip.position
        elif abs(lead) > abs(distance):
            grip.ramp = target
        grip.target = target
        grip.max_effort = abs(effort or 0.0) or law.own_effort
        grip.stall_position, grip.stall_since = grip.position, now
        grip.is_unheard = self._struct.is_monitored = True
        self._bound_grip(limits)

    def _store_grip(self, law: GripperLaw, controller: Controller) -> None:
        grip, now = law.grip, self._memory.grip
        if self._started_grip is not None and isinstance(controller, GripperDriver):
            controller.resume_from_kernel(
                now.target,
                now.max_effort,
                *self._started_grip,
                has_goal=bool(self._struct.is_monitored),
            )
            self._started_grip = None
        grip.ramp, grip.effort = now.ramp, now.effort
        grip.stall_position, grip.stall_since = now.stall_position, now.stall_since

    def _store_starts(self, controller: TrajectoryFollower, time: float) -> None:
        """Pass to Python the motions that the kernel has started or will start."""
        memory, start = self._memory, self._memory.start
        coming = start and start.coming()
        if memory.started.any():
            controller.resume_from_kernel(
                memory.started_splines(),
                time,
                is_first=start is not None and bool(start.struct.is_first),
                has_points=start is not None and bool(start.struct.has_points),
            )
            memory.started[:] = 0
        if coming:
            controller.command(*coming)

    def store(self, controller: Controller, time: float) -> None:
        """Copy the state to the controller; the next tick is at ``time`` [s]."""
        law, memory = self._law, self._memory
        if isinstance(controller, TrajectoryFollower):
            self._store_starts(controller, time)
        if law.pid is not None:
            law.pid.integrals[:] = memory.integrals.tolist()
        if isinstance(law, CommandLaw):
            law.last_errors[:] = memory.last_errors.tolist()
        elif isinstance(law, GripperLaw):
            self._store_grip(law, controller)
        elif isinstance(law.monitor, GoalMonitor):
            arrived: list[int] = np.flatnonzero(memory.arrived).tolist()
            law.monitor.note_arrived(arrived)


class Ended(IntEnum):
    """Reason why a run of the kernel ended."""

    DONE = 0
    """All ticks were executed."""
    EVENT = 1
    """Python must execute the next tick, or the remaining steps of the current tick."""
    CHECK = 2
    """Python must check whether the state has diverged, and then continue as after
    ``EVENT``."""
    MASSES = 3
    """Masses of servos must be computed (``refresh_masses``) before the run can
    continue."""
    MOBILITY = 4
    """Mobility of fast joints must be computed (``refresh_mobilities``) before the run
    can continue."""


REFRESHES = {Ended.MASSES: refresh_masses, Ended.MOBILITY: refresh_mobilities}
"""Functions that compute the quantities that are due, by the reason why a run ended."""
_ENDED = tuple(Ended)  # indexing takes a tenth of the time of Ended(...)


@final
class TickProgram:
    """Running controllers and drives of one robot in the kernel's memory.

    Between ``load`` and ``store``, the state of the controllers and drives is in the
    kernel's memory, and the Python objects are out of date.
    """

    def __init__(
        self,
        compiled: CDLL,
        running: Sequence[tuple[Controller, Sequence[int]]],
        specs: Sequence[ControllerSpec],
        laws: Sequence[Law],
        hardware: RobotHardware,
        *,
        dt: float,
        period: float,
    ) -> None:
        """Allocate the memory, without loading a state.

        Args:
            compiled: The library of the kernel.
            running: The running controllers and their joints, in load order.
            specs: The controllers' parameters.
            laws: The laws of the controllers, with one law per controller.
            hardware: The drives.
            dt: Length of a step of the engine [s].
            period: Length of a tick [s].
        """
        self._running, self._specs = running, specs
        self._hardware = hardware
        self._laws = [
            None if isinstance(law, IdleLaw) else _LoadedLaw(law, joints)
            for law, (_, joints) in zip(laws, running, strict=True)
        ]
        self._drives = NativeDrives(hardware)
        loaded = [law for law in self._laws if law is not None]
        self._robot = RobotMemory(len(hardware.joint_names), len(loaded))
        for law, struct in zip(loaded, self._robot.laws, strict=True):
            law.use(struct)
        self._struct = struct = self._robot.struct
        struct.dt, struct.period = dt, period
        struct.steps_per_tick = round(period / dt)
        struct.drives = addressof(self._drives.struct)
        self._stepper: NativeStepper | None = None
        self._loaded_at = 0
        self._compiled = compiled
        self._done = c_int()
        self._arguments = byref(struct), byref(self._done)

    def try_reuse(
        self,
        running: Sequence[tuple[Controller, Sequence[int]]],
        specs: Sequence[ControllerSpec],
    ) -> bool:
        """Use the memory for these controllers if it fits; return whether it fits.

        The memory fits if the controllers are the same, even if they were restarted,
        for example by a reset.  The controllers are executed after the next ``load``.
        """
        if running is self._running:
            return True
        is_fitting = len(specs) == len(self._specs) and all(
            one is other for one, other in zip(specs, self._specs, strict=True)
        )
        if is_fitting:
            self._running = running
        return is_fitting

    def load(
        self, laws: Sequence[Law], state: JointState, stepper: NativeStepper
    ) -> None:
        """Copy laws and drives, in joint state ``state``, to the kernel's memory."""
        for loaded, law in zip(self._laws, laws, strict=True):
            if loaded is not None and not isinstance(law, IdleLaw):
                loaded.load(law, state.time)
        self._drives.load()
        self._robot.command[:] = self._hardware.command
        self._robot.effort[:] = state.effort
        self._loaded_at = stepper.steps()
        self._struct.steps, self._struct.steps_left = self._loaded_at, 0
        self._use(stepper)

    def run(self, most: int, stepper: NativeStepper) -> tuple[Ended, int]:
        """Execute up to ``most`` ticks.

        Return the reason why the run ended, and the number of executed ticks.
        """
        self._use(stepper)
        robot, done = self._arguments
        executed = 0
        while True:
            ended = _ENDED[self._compiled.tool0_run(robot, most - executed, done)]
            executed += self._done.value
            refresh = REFRESHES.get(ended)
            if refresh is None:
                return ended, executed
            robots = np.array([self.robot_address], dtype=np.uintp)
            refresh(self._compiled, robots, self._hardware)

    def _use(self, stepper: NativeStepper) -> None:
        if stepper is not self._stepper:
            self._stepper = stepper
            self._robot.set_stepper(stepper)

    def note_steps(self, stepper: NativeStepper) -> bool:
        """Report the executed steps to the engine; return whether there were any."""
        before, steps = stepper.steps(), self.steps
        stepper.note_steps(steps, self._robot.effort.tolist())
        return steps > before

    def set_drive_limits(self, joint: int, limits: DriveLimits) -> None:
        """Limit the drive of a joint, given by number, as ``RobotHardware`` does."""
        before = self._drives.drive_limits.get(joint)
        if before is not limits and before != limits:  # a comparison takes microseconds
            self._drives.set_drive_limits(joint, limits)

    def start_grip(
        self,
        controller: int,
        target: float,
        effort: float | None,
        limits: DriveLimits,
        now: float,
    ) -> None:
        """Start a goal of a GripperActionController, given by number, at ``now``.

        The goal has no handle.  ``target`` and ``effort`` are those of
        ``GripperActionController.drive``.
        """
        law = self._laws[controller]
        assert law is not None
        law.start_grip(target, effort, limits, now)

    @property
    def n_controllers(self) -> int:
        """Number of running controllers, with and without a law."""
        return len(self._running)

    @property
    def robot_address(self) -> int:
        """Address of the robot's struct, for ``BatchKernel``."""
        return addressof(self._struct)

    @property
    def command(self) -> list[float]:
        """Last command of each joint."""
        command: list[float] = self._robot.command.tolist()
        return command

    @property
    def effort(self) -> FloatArray:
        """Efforts that were applied in the last step [N·m | N], as a view."""
        return self._robot.effort

    def law_address(self, controller: int) -> int:
        """Return the address of the law of a running controller, given by number."""
        laws = [law for law in self._laws[:controller] if law is not None]
        return addressof(self._robot.laws) + len(laws) * sizeof(LawStruct)

    @property
    def steps(self) -> int:
        """Number of engine steps since time 0."""
        steps: int = self._struct.steps
        return steps

    @property
    def has_stepped(self) -> bool:
        """Whether the engine has been stepped since the last ``load``."""
        return self.steps != self._loaded_at

    @property
    def step_address(self) -> tuple[int, int, int]:
        """Addresses of the last step's state, for ``ToolForcesKernel.of_steps``."""
        struct = self._struct
        return struct.step_position, struct.step_velocity, struct.velocity

    @property
    def steps_left(self) -> int:
        """Number of steps that Python must execute to finish the current tick."""
        left: int = self._struct.steps_left
        return left

    def tick_start(self) -> JointState:
        """Return the state at the start of the last tick or of the unfinished tick."""
        return self._robot.tick_start()

    def step_start(self) -> JointState:
        """Return the state at the start of the last step."""
        return self._robot.step_start()

    def store(self) -> None:
        """Copy the state to the controllers and drives."""
        time = self.steps * self._struct.dt
        for law, (controller, _) in zip(self._laws, self._running, strict=True):
            if law is not None:
                law.store(controller, time)
        self._drives.store()
        self._hardware.command[:] = self._robot.command.tolist()
