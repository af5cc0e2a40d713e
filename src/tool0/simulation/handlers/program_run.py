"""The execution of a program, from taking control of an arm to releasing it.

The program advances after each snapshot.
"""

from __future__ import annotations

import logging
from contextlib import suppress
from typing import TYPE_CHECKING, final

from msgspec.structs import replace

from tool0.errors import ControlError, Tool0Error
from tool0.programs.planning import ProgramPlan, StepError
from tool0.programs.step_descriptions import step_text
from tool0.protocol.arm_motion import ReturnArm, StopArm, TakeArm
from tool0.protocol.bus import WasReset
from tool0.protocol.goals import Goal, GoalResult, GoalStatus
from tool0.protocol.program import StepPath, path_text, walk
from tool0.protocol.programs import ProgramRun, RunState
from tool0.protocol.state import Snapshot
from tool0.simulation.handlers.program_steps import (
    BRAKE,
    EndedError,
    ProgramSteps,
    StepCoroutine,
)
from tool0.simulation.simulation import Simulation

if TYPE_CHECKING:
    from tool0.programs.robot_context import RobotContext

logger = logging.getLogger(__name__)


@final
class ProgramExecution:
    """Executes one program.

    Only the thread that executes the tick may advance the program; other threads may
    read its state.
    """

    def __init__(
        self,
        simulation: Simulation,
        plan: ProgramPlan,
        context: RobotContext,
        *,
        number: int,
        paused: bool,
    ) -> None:
        """Take control of the arm; the steps begin at the next snapshot.

        Raises:
            ControlError: If the arm may not move, or another program controls the arm.
        """
        self._simulation, self._arm = simulation, context.arm
        name, arm = plan.program.name, context.arm
        self._name = f"program '{name}'"
        self.goal = Goal(self._name)
        self.status = ProgramRun(run=number, program=name, arm=arm, state="running")
        self._steps_by_path = dict(walk(plan.program.steps))
        self._steps = ProgramSteps(
            simulation, plan, context, self._show_step, stepping=paused
        )
        self._stop: EndedError | None = None
        self._start = simulation.snapshot.time
        self._take()
        self._events = simulation.bus.subscribe(latest_only=True)
        self._script = self._run()

    # ---- requests from any thread --------------------------------------------------

    @property
    def is_stopping(self) -> bool:
        """Whether the program was stopped.

        A stopped program ends after its arm has been released.
        """
        return self._stop is not None

    def stop(self, reason: str) -> None:
        """End the program at the next snapshot."""
        self._stop = self._stop or EndedError("stopped", reason)

    def set_stepping(self, stepping: bool) -> None:
        """Set whether the program pauses before its next step."""
        self._steps.is_stepping = stepping

    # ---- snapshots ------------------------------------------------------------------

    def look(self, snapshot: Snapshot) -> None:
        """Continue the program after a snapshot."""
        self._steps.snapshot = snapshot
        try:
            next(self._script)
        except StopIteration:
            return
        except Exception:  # release the arm even after a bug
            logger.exception("%s failed", self._name)
            with suppress(Tool0Error):
                self._steps.call(ReturnArm(arm=self._arm))
            self._finish("failed", "it failed; the bring-up's log says more")
            return
        time = round(snapshot.time - self._start, 6)
        self._show(state="paused" if self._steps.is_paused else "running", time=time)

    def _run(self) -> StepCoroutine[None]:
        state: RunState = "succeeded"
        reason = ""
        try:
            yield from self._watched(self._steps.run())
        except EndedError as end:
            state, reason = end.state, str(end)
        except StepError as error:
            state, reason = "failed", error.problem.text
        except Tool0Error as error:
            state, reason = "failed", str(error)
        if state == "failed" and self.status.step:
            reason = f"step {path_text(self.status.step)}: {reason}"
        yield from self._release()
        self._finish(state, reason)

    def _watched(self, steps: StepCoroutine[None]) -> StepCoroutine[None]:
        """Execute steps, and end the program if the program may not continue."""
        while True:
            self._watch()
            try:
                next(steps)
            except StopIteration:
                return
            yield

    def _watch(self) -> None:
        """Raise EndedError if the program may not continue."""
        if self._stop is not None:
            raise self._stop
        events = self._events.events
        while events:
            if isinstance(events.popleft(), WasReset):
                raise EndedError("stopped", "the simulation was reset")
        if self._simulation.core.hardware.is_stopped:
            raise EndedError("stopped", "the emergency stop was engaged")
        box = self._steps.box
        if box.protective_stop:
            raise EndedError("stopped", f"protective stop: {box.protective_stop}")
        if not box.may_move:
            raise EndedError("stopped", "the arm was switched off")
        if box.motion_failure:
            raise EndedError("failed", box.motion_failure)
        if not box.taken_by or self._steps.arm.motion.is_returning:
            raise EndedError(
                "stopped", "something else stopped the arm or gave it back"
            )
        if box.taken_by != self._name:
            raise EndedError("stopped", f"'{box.taken_by}' took the arm")

    def _take(self) -> None:
        box = self._steps.box
        if box.taken_by:
            raise ControlError(f"'{box.taken_by}' moves the arm '{box.arm}'")
        self._steps.call(TakeArm(arm=self._arm, by=self._name))

    def _release(self) -> StepCoroutine[None]:
        """Stop and release the arm if the program still controls it."""
        self._events.close()
        if self._steps.box.taken_by != self._name:
            self._stop_path()
            return
        if self._steps.is_paused:
            # The clock of a paused path does not advance, so the path would never end.
            self._steps.call(StopArm(arm=self._arm, deceleration=BRAKE))
        self._steps.call(ReturnArm(arm=self._arm))
        while self._steps.box.taken_by == self._name:
            yield

    def _stop_path(self) -> None:
        """Stop the program's path after another program has taken the arm.

        The path is stopped only if the other program has not moved the arm yet.
        """
        with suppress(Tool0Error, EndedError):
            if not self._steps.is_done:
                stop = StopArm(arm=self._arm, deceleration=BRAKE, along_path=True)
                self._steps.call(stop)

    def _finish(self, state: RunState, reason: str) -> None:
        logger.log(
            logging.WARNING if state == "failed" else logging.INFO,
            "%s %s%s",
            self._name,
            state,
            f": {reason}" if reason else "",
        )
        self._show(state=state, error=reason)
        status = {
            "succeeded": GoalStatus.SUCCEEDED,
            "failed": GoalStatus.ABORTED,
        }.get(state, GoalStatus.PREEMPTED)
        self.goal.finish(GoalResult(status=status, error_string=reason))

    def _show_step(self, path: StepPath) -> None:
        if path != self.status.step:
            self._show(step=path, text=step_text(self._steps_by_path[path]))

    def _show(self, **changes: object) -> None:
        self.status = replace(self.status, **changes)
