"""Ticks without Python: which, and until when."""

from __future__ import annotations

from ctypes import byref, c_int
from enum import IntEnum
from typing import final

from tool0.control.manager import ControllerManager
from tool0.hardware.engine import Engine, JointState, NativeStepper
from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.library import Library, load_library
from tool0.kernel.program import Program


class RunResult(IntEnum):
    """Why the kernel returned."""

    DONE = 0
    """All ticks are executed."""
    EVENT = 1
    """Python executes the next tick, or the steps that are left of this one."""
    CHECK = 2
    """Python checks whether the state has diverged, and then as ``EVENT``."""


@final
class Kernel:
    """Executes the ticks of one robot until something happens.

    From ``load`` to ``store``, the state of controllers and drives is in the memory of
    the kernel, and the objects in Python are out of date.  Only the thread that owns
    the tick may use it.
    """

    def __init__(
        self,
        engine: Engine,
        hardware: RobotHardware,
        manager: ControllerManager,
        period: float,
    ) -> None:
        """Load nothing yet; ``period`` is that of a tick [s]."""
        self._engine, self._hardware, self._manager = engine, hardware, manager
        self._period = period
        self._library: Library | None = None
        if engine.stepper is not None:
            self._library = load_library()
        self._program: Program | None = None
        self._running: object = None
        """The running controllers that the program was made for."""
        self._stepper: NativeStepper | None = None
        self.is_loaded = False

    def load(self, state: JointState) -> bool:
        """Take over from ``state`` on; return False if only Python can tick."""
        stepper = self._engine.stepper
        if self._library is None or stepper is None:
            return False
        laws = self._manager.laws()
        if laws is None:
            return False
        if self._program is None or self._manager.running_set is not self._running:
            self._running, self._stepper = self._manager.running_set, None
            self._program = Program(
                laws, self._hardware, dt=self._engine.dt, period=self._period
            )
            self._done = c_int()
            self._arguments = byref(self._program.robot.struct), byref(self._done)
        self._program.load([law for law, _ in laws], state, stepper.steps())
        self.is_loaded = True
        return True

    def run(self, most: int) -> tuple[int, RunResult]:
        """Execute up to ``most`` ticks; return how many, and why no more."""
        program, stepper, library = self._program, self._engine.stepper, self._library
        assert program is not None and stepper is not None and library is not None
        if stepper is not self._stepper:
            self._stepper = stepper
            program.robot.set_stepper(stepper)
        robot, done = self._arguments
        result = library.tool0_run(robot, most, done)
        struct = program.robot.struct
        stepper.note_steps(struct.steps, program.robot.effort.tolist())
        return self._done.value, result
