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
        self._library = None if engine.stepper is None else library.load()
        self._program: Program | None = None
        self.is_loaded = False

    def load(self, state: JointState) -> bool:
        """Take over from ``state`` on; return False if only Python can tick."""
        stepper, laws = self._engine.stepper, self._manager.laws()
        if self._library is None or stepper is None or laws is None:
            return False
        program = self._program
        if program is None or not program.fits(laws):
            program = self._program = Program(
                self._library, laws, self._hardware, self._engine.dt, self._period
            )
        program.load(laws, stepper, state)
        self.is_loaded = True
        return True
