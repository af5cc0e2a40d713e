"""The ticks of one robot, executed by the kernel until an event."""

from __future__ import annotations

import math
from collections.abc import Sequence
from ctypes import addressof
from typing import final

import numpy as np

from tool0.control.law import CommandLaw, IdleLaw, Law, TrajectoryLaw
from tool0.control.sampler import pieces_from
from tool0.hardware.engine import JointState, NativeStepper
from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.drives import NativeDrives
from tool0.kernel.memory import (
    MOST_PIECES,
    FloatArray,
    LawMemory,
    LawStruct,
    RobotStruct,
    packed,
)


@final
class RobotMemory:
    """The struct of one robot, with its state between ticks."""

    def __init__(self, n_joints: int, laws: Sequence[LawStruct]) -> None:
        self.laws = (LawStruct * len(laws))(*laws)
        self.command: FloatArray = np.zeros(n_joints)
        self.effort: FloatArray = np.zeros(n_joints)
        self._tick: FloatArray = np.zeros((3, n_joints))
        self._step: FloatArray = np.zeros((3, n_joints))
        self.struct = struct = RobotStruct(n_joints=n_joints, n_laws=len(laws))
        struct.laws = addressof(self.laws)
        struct.command = self.command.ctypes.data
        struct.effort = self.effort.ctypes.data
        for at, rows in (("tick", self._tick), ("step", self._step)):
            for row, name in zip(rows, ("position", "velocity", "effort"), strict=True):
                setattr(struct, f"{at}_{name}", row.ctypes.data)

    def set_stepper(self, stepper: NativeStepper) -> None:
        """Step this engine from now on."""
        self._motor_joints = np.array(stepper.motor_joints, dtype=np.int32)
        struct = self.struct
        struct.step, struct.model = stepper.step, stepper.model
        struct.data = stepper.data
        struct.position, struct.velocity = stepper.position, stepper.velocity
        struct.n_velocities, struct.motors = stepper.n_velocities, stepper.motors
        struct.n_motors = len(self._motor_joints)
        struct.motor_joints = self._motor_joints.ctypes.data

    def tick_start(self) -> JointState:
        """Return the state at the start of the last tick, or of an unfinished one."""
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
    """A law of a running controller in the kernel's memory."""

    def __init__(self, law: TrajectoryLaw | CommandLaw, joints: Sequence[int]) -> None:
        self._memory = LawMemory(law, joints)
        self.struct = LawStruct()
        self._memory.fill(self.struct, law)
        self._law = law
        self._rows = law.pid and law.pid.rows
        self._packed: tuple[object, object] | None = None
        self._known_until = -math.inf

    def load(self, law: TrajectoryLaw | CommandLaw, time: float) -> None:
        """Take the law as it is at ``time`` [s]."""
        memory, pid = self._memory, law.pid
        self._law = law
        if pid is not None:
            if pid.rows is not self._rows:
                self._rows = pid.rows
                memory.gains[:] = [row[1:] for row in pid.rows]
            memory.integrals[0] = pid.integrals
        if isinstance(law, TrajectoryLaw):
            self._load_motion(law, time)
        else:
            memory.values[0] = law.values
            memory.last_errors[0] = law.last_errors

    def _load_motion(self, law: TrajectoryLaw, time: float) -> None:
        memory, struct, monitor = self._memory, self.struct, law.monitor
        motion = law.sampler, monitor
        if motion != self._packed or time >= self._known_until:
            self._packed, self._known_until = motion, math.inf
            for k, spline in enumerate(law.sampler.splines):
                pieces = pieces_from(spline, time, MOST_PIECES)
                memory.pieces[0, k, : len(pieces)] = [
                    packed(piece, monitor) for piece in pieces
                ]
                memory.n_pieces[0, k] = len(pieces)
                self._known_until = min(self._known_until, pieces[-1].until)
            memory.piece[:] = 0
            struct.next_change = -math.inf
        struct.is_monitored = monitor is not None
        if monitor is not None:
            struct.goal_time = monitor.goal_time
            memory.arrived[:] = 0
            memory.arrived[0, list(monitor.arrived)] = 1

    def store(self) -> None:
        """Give the controller its state back."""
        law, memory = self._law, self._memory
        if law.pid is not None:
            law.pid.integrals[:] = memory.integrals[0].tolist()
        if isinstance(law, CommandLaw):
            law.last_errors[:] = memory.last_errors[0].tolist()
        elif law.monitor is not None:
            arrived: list[int] = np.flatnonzero(memory.arrived[0]).tolist()
            law.monitor.note_arrived(arrived)


@final
class Program:
    """The running controllers and drives of one robot in the kernel's memory."""

    def __init__(
        self,
        laws: Sequence[tuple[Law, Sequence[int]]],
        hardware: RobotHardware,
        *,
        dt: float,
        period: float,
    ) -> None:
        """Allocate the memory for these laws, with their joints; nothing is loaded.

        ``dt`` [s] is the length of a step, ``period`` [s] that of a tick.
        """
        self._hardware = hardware
        self._laws = [
            None if isinstance(law, IdleLaw) else _LoadedLaw(law, joints)
            for law, joints in laws
        ]
        self._drives = NativeDrives(hardware)
        self.robot = robot = RobotMemory(
            len(hardware.joint_names), [law.struct for law in self._laws if law]
        )
        for law, struct in zip(filter(None, self._laws), robot.laws, strict=True):
            law.struct = struct
        robot.struct.dt, robot.struct.period = dt, period
        robot.struct.steps_per_tick = round(period / dt)
        robot.struct.drives = addressof(self._drives.struct)

    def load(self, laws: Sequence[Law], state: JointState, steps: int) -> None:
        """Take over the controllers and drives; ``steps`` are those of the engine."""
        robot = self.robot
        robot.struct.steps = steps
        for loaded, law in zip(self._laws, laws, strict=True):
            if loaded is not None and not isinstance(law, IdleLaw):
                loaded.load(law, state.time)
        self._drives.load()
        robot.command[:] = self._hardware.command
        robot.effort[:] = state.effort

    def store(self) -> None:
        """Give controllers and drives their state back."""
        for law in self._laws:
            if law is not None:
                law.store()
        self._drives.store()
        self._hardware.command[:] = self.robot.command.tolist()
