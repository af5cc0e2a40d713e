"""Selection of the ticks that are executed by the compiled kernel."""

from __future__ import annotations

from typing import final

from tool0.control.law import Law
from tool0.control.manager import ControllerManager
from tool0.hardware.engine import Engine, JointState
from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel import library
from tool0.kernel.program import TickProgram


@final
class Kernel:
    """Selector of the ticks that the compiled kernel executes for one robot.

    Only the thread of the tick may use this object.
    """

    def __init__(
        self,
        engine: Engine,
        hardware: RobotHardware,
        manager: ControllerManager,
        period: float,
    ) -> None:
        """Prepare without loading anything; ``period`` is the length of a tick [s]."""
        self._engine, self._hardware, self._manager = engine, hardware, manager
        self._period = period
        self._compiled = None if engine.stepper is None else library.load()
        self._program: TickProgram | None = None

    def load(self, state: JointState) -> TickProgram | None:
        """Return a program for the ticks that start at ``state``, or None.

        The result is None if there is no compiled kernel, if the kernel cannot step the
        engine, or if a controller has no law.  Only Python can execute the ticks in
        these cases.
        """
        stepper, compiled = self._engine.stepper, self._compiled
        if compiled is None or stepper is None:
            return None
        running = self._manager.running_controllers
        laws: list[Law] = []
        for controller, _ in running:
            law = controller.law()
            if law is None:
                return None
            laws.append(law)
        program = self._program
        if program is None or not program.try_reuse(
            running, self._manager.running_specs
        ):
            program = TickProgram(
                compiled,
                running,
                self._manager.running_specs,
                laws,
                self._hardware,
                dt=self._engine.dt,
                period=self._period,
            )
            self._program = program
        program.load(laws, state, stepper)
        return program
