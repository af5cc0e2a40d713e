"""The execution of a program: its steps as requests, snapshot by snapshot.

Steps are a generator that waits for the next snapshot wherever time must pass.  Every
change is made by the request that a client would send, so that the journal has it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future
from contextlib import suppress
from threading import Thread
from typing import TYPE_CHECKING, Final, TypeVar, final

from msgspec.structs import replace

from tool0.errors import ControlError, Tool0Error
from tool0.programs.planning import (
    NumberedMove,
    ProgramPath,
    ProgramPlan,
    StepError,
    moves_from,
    plan_path,
    plan_search,
)
from tool0.programs.step_descriptions import step_text
from tool0.protocol.arm_motion import ReturnArm, StopArm, TakeArm, path_request
from tool0.protocol.bus import WasReset
from tool0.protocol.control_box import PauseProgram, SetIO
from tool0.protocol.control_box_state import ControlBoxState, ProgramState
from tool0.protocol.goals import Goal, GoalResult, GoalStatus
from tool0.protocol.gripper import Grip
from tool0.protocol.objects import PlaceObject
from tool0.protocol.program import (
    CommentStep,
    GripperStep,
    LoopStep,
    MoveStep,
    PlaceObjectStep,
    SetOutputStep,
    Step,
    StepPath,
    UntilStep,
    WaitStep,
    path_text,
    walk,
)
from tool0.protocol.programs import ProgramRun, RunState
from tool0.protocol.request import Request, Response
from tool0.protocol.state import Snapshot
from tool0.sensing.grasp import GraspDetector
from tool0.simulation.handlers.program_touch import Touch
from tool0.simulation.handlers.table import answer
from tool0.simulation.simulation import Simulation

if TYPE_CHECKING:
    from tool0.control.arm.motion import ArmMotionController
    from tool0.programs.robot_context import RobotContext

logger = logging.getLogger(__name__)
T = TypeVar("T")
StepCoroutine = Generator[None, None, T]
"""Waits for a snapshot wherever it yields."""

_BRAKE: Final = 4.0
"""Change of a path's speed where a step is executed alone from within it [1/s²]."""
_GRIP_TIMEOUT: Final = 10.0
"""Simulated time that a gripper may take to stand still [s]."""
_ROUNDING: Final = 1e-9


class _EndedError(Exception):
    """The program ends before its last step."""

    def __init__(self, state: RunState, reason: str) -> None:
        super().__init__(reason)
        self.state: RunState = state


@final
class ProgramExecution:
    """Executes one program.  The thread of the tick uses it; any thread may read."""

    def __init__(
        self,
        simulation: Simulation,
        plan: ProgramPlan,
        context: RobotContext,
        *,
        number: int,
        paused: bool,
    ) -> None:
        """Take the arm; steps begin at the next snapshot.

        Raises:
            ControlError: If the arm may not move, or is taken already.
        """
        self._simulation, self._plan, self._context = simulation, plan, context
        name, arm = plan.program.name, context.arm
        self._arm = simulation.core.arms.find(arm)
        self._name = f"program '{name}'"
        self.goal = Goal(self._name)
        self.status = ProgramRun(run=number, program=name, arm=arm, state="running")
        self._steps_by_path = dict(walk(plan.program.steps))
        self._stepping = paused
        """Whether it pauses before its next step."""
        self._stop: _EndedError | None = None
        self._path_number = 0
        """Of the last path that it sent."""
        self._snapshot = simulation.snapshot
        self._start = self._snapshot.time
        self._take()
        self._events = simulation.bus.subscribe(latest_only=True)
        self._script = self._run()

    @property
    def arm(self) -> str:
        """The arm that it moves."""
        return self._context.arm

    # ---- requests: any thread ------------------------------------------------------

    @property
    def is_stopping(self) -> bool:
        """Whether it was stopped, and ends as soon as its arm has been given back."""
        return self._stop is not None

    def stop(self, reason: str) -> None:
        """End it at the next snapshot."""
        self._stop = self._stop or _EndedError("stopped", reason)

    def set_stepping(self, stepping: bool) -> None:
        """Choose whether it pauses before its next step."""
        self._stepping = stepping

    # ---- snapshots ------------------------------------------------------------------

    def look(self, snapshot: Snapshot) -> None:
        """Go on after a snapshot."""
        self._snapshot = snapshot
        try:
            next(self._script)
        except StopIteration:
            return
        except Exception:  # a bug must not lose the robot
            logger.exception("%s failed", self._name)
            with suppress(Tool0Error):
                self._call(ReturnArm(arm=self.arm))
            self._finish("failed", "it failed; the bring-up's log says more")
            return
        time = round(snapshot.time - self._start, 6)
        self._show(state="paused" if self._is_paused else "running", time=time)

    def _run(self) -> StepCoroutine[None]:
        state: RunState = "succeeded"
        reason = ""
        try:
            yield from self._watched(self._steps(self._plan.program.steps, ()))
        except _EndedError as end:
            state, reason = end.state, str(end)
        except StepError as error:
            state, reason = "failed", error.problem.text
        except Tool0Error as error:
            state, reason = "failed", str(error)
        if state == "failed" and self.status.step:
            reason = f"step {path_text(self.status.step)}: {reason}"
        yield from self._give_back()
        self._finish(state, reason)

    def _watched(self, steps: StepCoroutine[None]) -> StepCoroutine[None]:
        """Execute steps; end them when something else has happened to the arm."""
        while True:
            self._watch()
            try:
                next(steps)
            except StopIteration:
                return
            yield

    def _watch(self) -> None:
        """Raise _EndedError if the program may not go on."""
        if self._stop is not None:
            raise self._stop
        events = self._events.events
        while events:
            if isinstance(events.popleft(), WasReset):
                raise _EndedError("stopped", "the simulation was reset")
        if self._simulation.core.hardware.is_stopped:
            raise _EndedError("stopped", "the emergency stop was engaged")
        box = self._box
        if box.protective_stop:
            raise _EndedError("stopped", f"protective stop: {box.protective_stop}")
        if not box.may_move:
            raise _EndedError("stopped", "the arm was switched off")
        if box.motion_failure:
            raise _EndedError("failed", box.motion_failure)
        if not box.taken_by or self._arm.motion.is_returning:
            raise _EndedError(
                "stopped", "something else stopped the arm or gave it back"
            )
        if box.taken_by != self._name:
            raise _EndedError("stopped", f"'{box.taken_by}' took the arm")

    def _take(self) -> None:
        box = self._box
        if box.taken_by:
            raise ControlError(f"'{box.taken_by}' moves the arm '{box.arm}'")
        self._call(TakeArm(arm=self.arm, by=self._name))

    def _give_back(self) -> StepCoroutine[None]:
        """Stop the arm, and let its controllers start again, if it is still taken."""
        self._events.close()
        if self._box.taken_by != self._name:
            self._stop_path()
            return
        if self._is_paused:
            # The clock of a paused path stands still, so it would never end.
            self._call(StopArm(arm=self.arm, deceleration=_BRAKE))
        self._call(ReturnArm(arm=self.arm))
        while self._box.taken_by == self._name:
            yield

    def _stop_path(self) -> None:
        """Stop its path, if somebody has taken the arm and not moved it yet."""
        with suppress(Tool0Error, _EndedError):
            if not self._is_done:
                stop = StopArm(arm=self.arm, deceleration=_BRAKE, along_path=True)
                self._call(stop)

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

    # ---- steps ----------------------------------------------------------------------

    def _steps(self, steps: Sequence[Step], parents: StepPath) -> StepCoroutine[None]:
        index = 0
        while index < len(steps):
            step, path = steps[index], (*parents, index + 1)
            if isinstance(step, MoveStep):
                moves = moves_from(steps, index, parents)
                yield from self._moves(moves)
                index = moves[-1].path[-1]
                continue
            if isinstance(step, LoopStep):
                yield from self._loop(step, path)
            elif not isinstance(step, CommentStep):
                yield from self._gate(path)
                yield from self._step(path, step)
            index += 1

    def _step(self, path: StepPath, step: Step) -> StepCoroutine[None]:
        match step:
            case GripperStep():
                yield from self._grip(step)
            case WaitStep():
                yield from self._wait(step)
            case UntilStep():
                yield from self._search(path, step)
            case PlaceObjectStep():
                self._call(PlaceObject(name=step.name, xyz=step.xyz, rpy=step.rpy))
            case SetOutputStep(output=pin, level=level):
                self._call(SetIO(arm=self.arm, digital_outputs={pin: level}))

    def _loop(self, loop: LoopStep, path: StepPath) -> StepCoroutine[None]:
        count = 0
        while loop.times is None or count < loop.times:
            pin = loop.while_input
            if pin is not None and self._box.digital_inputs[pin] != loop.level:
                return
            if count:
                yield  # an endless loop must let time pass
            yield from self._steps(loop.steps, path)
            count += 1

    def _gate(self, path: StepPath) -> StepCoroutine[None]:
        """Begin a step, or pause before it."""
        self._show_step(path)
        if self._stepping and not self._is_paused:
            self._call(PauseProgram(arm=self.arm))
        while self._is_paused:
            yield

    def _moves(self, moves: Sequence[NumberedMove]) -> StepCoroutine[None]:
        """Move through targets; one by one while it is stepped."""
        done = 0
        has_begun = False  # the next one
        while done < len(moves):
            if not has_begun:
                yield from self._gate(moves[done].path)
            rest = moves[done : done + 1] if self._stepping else moves[done:]
            path = yield from self._path(rest)
            n_moves = yield from self._follow(path)
            has_begun = n_moves < len(rest)
            done += n_moves

    def _path(self, moves: Sequence[NumberedMove]) -> StepCoroutine[ProgramPath]:
        q = self._setpoint
        known = self._plan.find(moves[0].path, q)
        if known is not None and len(known.steps) == len(moves):
            return known
        found = yield from self._planned(lambda: plan_path(self._context, moves, q))
        return found

    def _follow(self, path: ProgramPath) -> StepCoroutine[int]:
        """Follow a path; return how many of its moves are done."""
        yield from self._start_path(path)
        plan, n_moves = path.plan, len(path.steps)
        while not self._is_done:
            move = plan.move_at(self._path_time)
            self._show_step(path.steps[move])
            if self._stepping and n_moves > 1 and not self._is_paused:
                stop = StopArm(arm=self.arm, deceleration=_BRAKE, along_path=True)
                self._call(stop)
                yield from self._rest()
                return plan.move_at(self._path_time)
            yield
        self._require_whole(path)
        return n_moves

    def _start_path(self, path: ProgramPath) -> StepCoroutine[None]:
        """Let the arm begin a path, and wait for the next snapshot."""
        if path.plan.duration > 0.0:
            self._path_number = self._call(path_request(self.arm, path.plan.path))
            yield

    def _require_whole(self, path: ProgramPath) -> None:
        duration = path.plan.duration
        is_left = self._motion.mode != "path"
        if duration > 0.0 and (is_left or self._path_time < duration - _ROUNDING):
            raise _EndedError("stopped", "something else stopped the arm on its path")

    def _search(self, path: StepPath, step: UntilStep) -> StepCoroutine[None]:
        q = self._setpoint
        found = self._plan.find(path, q) or (
            yield from self._planned(lambda: plan_search(self._context, path, step, q))
        )
        touch = Touch(self._simulation, self._context, step)
        yield from self._start_path(found)
        while not self._is_done:
            if touch.has_occurred():
                rate = min(max(step.acceleration / step.speed, _BRAKE), 1000.0)
                stop = StopArm(arm=self.arm, deceleration=rate, along_path=True)
                self._call(stop)
                yield from self._rest()
                return
            yield
        self._require_whole(found)
        if step.must_touch and not touch.has_occurred():
            what = "no contact" if step.force is None else f"less than {step.force:g} N"
            raise _EndedError(
                "failed", f"{what} on the whole way of {step.distance:g} m"
            )

    def _grip(self, step: GripperStep) -> StepCoroutine[None]:
        context = self._context
        geometry = context.geometry
        assert geometry is not None  # it was planned
        detector = GraspDetector(geometry)
        started = self._call(
            Grip(
                gripper=context.gripper,
                opening=context.opening(step),
                speed=step.speed,
                force=step.force,
            )
        )
        goal = self._simulation.goals.find(started.goal)
        end = self._snapshot.time + _GRIP_TIMEOUT
        while True:
            yield
            state = detector.observe(self._snapshot)
            if goal.status.is_terminal and state.motion != "moving":
                break
            if self._snapshot.time > end:
                if state.motion == "blocked":
                    break  # it may creep, and so has not stalled
                raise _EndedError(
                    "failed", f"the gripper still moves after {_GRIP_TIMEOUT} s"
                )
        if goal.status is GoalStatus.PREEMPTED:
            raise _EndedError("stopped", "something else moved the gripper")
        if state.motion == "blocked":
            reason = self._simulation.executor.supervision.gripper_obstacle(
                geometry.joint
            )
            raise _EndedError(
                "failed", f"the gripper is blocked and holds nothing ({reason})"
            )
        if step.must_hold and not state.motion.startswith("holding"):
            raise _EndedError(
                "failed", f"the gripper holds nothing: it is '{state.motion}'"
            )

    def _wait(self, step: WaitStep) -> StepCoroutine[None]:
        left = float("inf") if step.duration is None else step.duration
        pin = step.input
        while True:
            if pin is not None and self._box.digital_inputs[pin] == step.level:
                return
            if left <= _ROUNDING:
                break
            before = self._snapshot.time
            yield
            if not self._is_paused:
                left -= self._snapshot.time - before
        if pin is not None:
            level = "high" if step.level else "low"
            text = f"input {pin} was not {level} within {step.duration:g} s"
            raise _EndedError("failed", text)

    # ---- the robot ------------------------------------------------------------------

    def _call(self, request: Request[Response]) -> Response:
        return answer(self._simulation, request)

    def _planned(self, plan: Callable[[], T]) -> StepCoroutine[T]:
        """Plan while the arm rests; in real time, in a thread of its own."""
        if not self._simulation.loop.is_realtime:
            return plan()
        future: Future[T] = Future()

        def work() -> None:
            try:
                future.set_result(plan())
            except BaseException as error:
                future.set_exception(error)

        Thread(target=work, name="tool0 program", daemon=True).start()
        while not future.done():
            yield
        return future.result()

    @property
    def _box(self) -> ControlBoxState:
        return self._arm.box.state

    @property
    def _is_paused(self) -> bool:
        return self._box.program is ProgramState.PAUSED

    @property
    def _motion(self) -> ArmMotionController:
        """What moves the arm; _EndedError if something else does."""
        motion = self._arm.controller_to_move()
        number, _ = motion.progress(self._simulation.core.time)
        if number != self._path_number or motion.mode not in {"path", "hold", "stop"}:
            raise _EndedError("stopped", "something else moves the arm")
        return motion

    @property
    def _setpoint(self) -> list[float]:
        return list(self._motion.motion(self._simulation.core.time).positions)

    @property
    def _is_done(self) -> bool:
        return self._motion.is_done(self._simulation.core.time)

    @property
    def _path_time(self) -> float:
        return self._motion.progress(self._simulation.core.time)[1]

    def _rest(self) -> StepCoroutine[None]:
        while not self._is_done:
            yield

    def _show_step(self, path: StepPath) -> None:
        if path != self.status.step:
            self._show(step=path, text=step_text(self._steps_by_path[path]))

    def _show(self, **changes: object) -> None:
        self.status = replace(self.status, **changes)
