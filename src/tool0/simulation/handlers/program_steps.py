"""The execution of a program's steps with the same requests that clients send.

The steps are a generator that yields until the next snapshot whenever simulated time
must pass.  Each change uses the request that a client would send, so that the journal
contains it.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future
from threading import Thread
from typing import TYPE_CHECKING, Final, TypeVar, final

from tool0.programs.planning import (
    NumberedMove,
    ProgramPath,
    ProgramPlan,
    is_planned,
    moves_from,
    plan_path,
    plan_search,
    plan_way,
)
from tool0.protocol.arm_motion import StopArm, path_request
from tool0.protocol.control_box import PauseProgram, SetIO
from tool0.protocol.control_box_state import ControlBoxState, ProgramState
from tool0.protocol.goals import GoalStatus
from tool0.protocol.gripper import Grip
from tool0.protocol.objects import PlaceObject
from tool0.protocol.program import (
    CommentStep,
    GripperStep,
    LoopStep,
    MoveJointStep,
    MoveStep,
    PlaceObjectStep,
    SetOutputStep,
    Step,
    StepPath,
    UntilStep,
    WaitStep,
    path_text,
)
from tool0.protocol.programs import RunState
from tool0.protocol.request import Request, Response
from tool0.sensing.grasp import GraspDetector
from tool0.simulation.handlers.motion_checks import motion_plans
from tool0.simulation.handlers.program_touch import Touch
from tool0.simulation.handlers.table import answer
from tool0.simulation.simulation import Simulation
from tool0.simulation.supervision.plan_watch import ContactWatch, links_moved_by

if TYPE_CHECKING:
    from tool0.control.arm.motion import ArmMotionController
    from tool0.description.scene_state import Contact
    from tool0.programs.robot_context import RobotContext

T = TypeVar("T")
StepCoroutine = Generator[None, None, T]
"""A coroutine that waits for the next snapshot at each ``yield``."""

BRAKE: Final = 4.0
"""Rate of change of a path's speed factor when a single step ends within the path
[1/s]."""
_GRIP_TIMEOUT: Final = 10.0
"""Simulated time within which a gripper must come to rest [s]."""
_ROUNDING: Final = 1e-9


class EndedError(Exception):
    """Raised to end the program before its last step."""

    def __init__(self, state: RunState, reason: str) -> None:
        super().__init__(reason)
        self.state: RunState = state


@final
class ProgramSteps:
    """Executes the steps of a program.

    Only the thread that executes the tick may use ``ProgramSteps``.
    """

    def __init__(
        self,
        simulation: Simulation,
        plan: ProgramPlan,
        context: RobotContext,
        when_begun: Callable[[StepPath], None],
        *,
        stepping: bool,
    ) -> None:
        """Prepare the execution; ``when_begun`` is called at the start of each step."""
        self._simulation, self._plan, self._context = simulation, plan, context
        self._when_begun = when_begun
        self.is_stepping = stepping
        """Whether the program pauses before its next step."""
        self.snapshot = simulation.snapshot
        """Latest snapshot."""
        self.arm = simulation.core.arms.find(context.arm)
        self._path_number = 0
        """Number of the last path that the program started."""

    def run(self) -> StepCoroutine[None]:
        """Execute all steps.

        EndedError or a Tool0Error is raised if the program ends early.
        """
        yield from self._steps(self._plan.program.steps, ())

    def _steps(self, steps: Sequence[Step], parents: StepPath) -> StepCoroutine[None]:
        index = 0
        while index < len(steps):
            step, path = steps[index], (*parents, index + 1)
            if isinstance(step, MoveStep) and not is_planned(step):
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
            case MoveJointStep():
                yield from self._way(path, step)
            case GripperStep():
                yield from self._grip(step)
            case WaitStep():
                yield from self._wait(step)
            case UntilStep():
                yield from self._search(path, step)
            case PlaceObjectStep():
                self.call(PlaceObject(name=step.name, xyz=step.xyz, rpy=step.rpy))
            case SetOutputStep(output=pin, level=level):
                self.call(SetIO(arm=self.arm.name, digital_outputs={pin: level}))

    def _loop(self, loop: LoopStep, path: StepPath) -> StepCoroutine[None]:
        count = 0
        while loop.times is None or count < loop.times:
            pin = loop.while_input
            if pin is not None and self.box.digital_inputs[pin] != loop.level:
                return
            if count:
                yield  # time must pass in an endless loop
            yield from self._steps(loop.steps, path)
            count += 1

    def _gate(self, path: StepPath) -> StepCoroutine[None]:
        """Begin a step, or pause the program before the step."""
        self._when_begun(path)
        if self.is_stepping and not self.is_paused:
            self.call(PauseProgram(arm=self.arm.name))
        while self.is_paused:
            yield

    def _moves(self, moves: Sequence[NumberedMove]) -> StepCoroutine[None]:
        """Move through targets; in single-step mode, stop at each target."""
        done = 0
        has_begun = False  # the next one
        while done < len(moves):
            if not has_begun:
                yield from self._gate(moves[done].path)
            rest = moves[done : done + 1] if self.is_stepping else moves[done:]
            path = yield from self._path(rest)
            yield from self._require_free(path)
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

    def _way(self, path: StepPath, step: MoveJointStep) -> StepCoroutine[None]:
        """Plan a motion around obstacles, and execute the motion.

        An unexpected contact ends the program.
        """
        q = self._setpoint
        found = yield from self._planned(lambda: plan_way(self._context, path, step, q))
        watch = ContactWatch(
            links_moved_by(self._context.model, self._context.joint_names),
            self._contacts,
            carried=motion_plans(self._simulation).carried(self.snapshot),
        )
        yield from self._follow(found, watch)

    def _require_free(self, path: ProgramPath) -> StepCoroutine[None]:
        """End the program if the arm would collide on a path.

        Programs that ignore collisions are not checked.
        """
        if self._plan.program.collision == "ignore" or path.plan.duration == 0.0:
            return
        names, q = self._context.joint_names, self._setpoint
        now = {**self.snapshot.positions, **dict(zip(names, q, strict=True))}
        plans = motion_plans(self._simulation)
        found = yield from self._planned(lambda: plans.check_path(path.plan.path, now))
        if not found.is_free:
            step = path.steps[path.plan.move_at(found.time)]
            way = f"the way of step {path_text(step)}"
            if step == path.steps[0]:
                way = "its way"
            raise EndedError(
                "failed", f"the arm would collide on {way}: {found.reason}"
            )

    def _follow(
        self, path: ProgramPath, watch: ContactWatch | None = None
    ) -> StepCoroutine[int]:
        """Follow a path, and return the number of its completed moves."""
        yield from self._start_path(path)
        plan, n_moves = path.plan, len(path.steps)
        while not self.is_done:
            if watch is not None and (reason := watch.unexpected(self._contacts)):
                raise EndedError("failed", reason)
            move = plan.move_at(self._path_time)
            self._when_begun(path.steps[move])
            if self.is_stepping and n_moves > 1 and not self.is_paused:
                stop = StopArm(arm=self.arm.name, deceleration=BRAKE, along_path=True)
                self.call(stop)
                yield from self._rest()
                return plan.move_at(self._path_time)
            yield
        self._require_whole(path)
        return n_moves

    def _start_path(self, path: ProgramPath) -> StepCoroutine[None]:
        """Start a path of the arm, and wait for the next snapshot."""
        if path.plan.duration > 0.0:
            self._path_number = self.call(path_request(self.arm.name, path.plan.path))
            yield

    def _require_whole(self, path: ProgramPath) -> None:
        duration = path.plan.duration
        is_left = self._motion.mode != "path"
        if duration > 0.0 and (is_left or self._path_time < duration - _ROUNDING):
            raise EndedError("stopped", "something else stopped the arm on its path")

    def _search(self, path: StepPath, step: UntilStep) -> StepCoroutine[None]:
        q = self._setpoint
        found = self._plan.find(path, q) or (
            yield from self._planned(lambda: plan_search(self._context, path, step, q))
        )
        touch = Touch(self._simulation, self._context, step)
        yield from self._start_path(found)
        while not self.is_done:
            if touch.has_occurred():
                rate = min(max(step.acceleration / step.speed, BRAKE), 1000.0)
                stop = StopArm(arm=self.arm.name, deceleration=rate, along_path=True)
                self.call(stop)
                yield from self._rest()
                return
            yield
        self._require_whole(found)
        if step.must_touch and not touch.has_occurred():
            what = "no contact" if step.force is None else f"less than {step.force:g} N"
            raise EndedError(
                "failed", f"{what} on the whole way of {step.distance:g} m"
            )

    def _grip(self, step: GripperStep) -> StepCoroutine[None]:
        context = self._context
        geometry = context.geometry
        assert geometry is not None  # it was planned
        detector = GraspDetector(geometry)
        started = self.call(
            Grip(
                gripper=context.gripper,
                opening=context.opening(step),
                speed=step.speed,
                force=step.force,
            )
        )
        goal = self._simulation.goals.find(started.goal)
        end = self.snapshot.time + _GRIP_TIMEOUT
        while True:
            yield
            state = detector.observe(self.snapshot)
            if goal.status.is_terminal and state.motion != "moving":
                break
            if self.snapshot.time > end:
                if state.motion == "blocked":
                    break  # slow creep is not a stall
                raise EndedError(
                    "failed", f"the gripper still moves after {_GRIP_TIMEOUT} s"
                )
        if goal.status is GoalStatus.PREEMPTED:
            raise EndedError("stopped", "something else moved the gripper")
        if state.motion == "blocked":
            reason = self._simulation.executor.supervision.gripper_obstacle(
                geometry.joint
            )
            raise EndedError(
                "failed", f"the gripper is blocked and holds nothing ({reason})"
            )
        if step.must_hold and not state.motion.startswith("holding"):
            raise EndedError(
                "failed", f"the gripper holds nothing: it is '{state.motion}'"
            )

    def _wait(self, step: WaitStep) -> StepCoroutine[None]:
        left = float("inf") if step.duration is None else step.duration
        pin = step.input
        while True:
            if pin is not None and self.box.digital_inputs[pin] == step.level:
                return
            if left <= _ROUNDING:
                break
            before = self.snapshot.time
            yield
            if not self.is_paused:
                left -= self.snapshot.time - before
        if pin is not None:
            level = "high" if step.level else "low"
            text = f"input {pin} was not {level} within {step.duration:g} s"
            raise EndedError("failed", text)

    # ---- the robot ------------------------------------------------------------------

    def call(self, request: Request[Response]) -> Response:
        """Execute a request as if a client had sent it."""
        return answer(self._simulation, request)

    def _planned(self, plan: Callable[[], T]) -> StepCoroutine[T]:
        """Plan while the arm is at rest.

        In real time, a dedicated thread executes the planning.
        """
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
    def box(self) -> ControlBoxState:
        """State of the arm's control box."""
        return self.arm.box.state

    @property
    def is_paused(self) -> bool:
        """Whether the program is paused."""
        return self.box.program is ProgramState.PAUSED

    @property
    def _contacts(self) -> tuple[Contact, ...]:
        return self._simulation.core.engine.world.contacts()

    @property
    def _motion(self) -> ArmMotionController:
        """The arm's controller.

        EndedError is raised if another program or client moves the arm.
        """
        motion = self.arm.controller_to_move()
        number, _ = motion.progress(self._simulation.core.time)
        if number != self._path_number or motion.mode not in {"path", "hold", "stop"}:
            raise EndedError("stopped", "something else moves the arm")
        return motion

    @property
    def _setpoint(self) -> list[float]:
        return list(self._motion.motion(self._simulation.core.time).positions)

    @property
    def is_done(self) -> bool:
        """Whether the arm is at rest.

        EndedError is raised if another program or client moves the arm.
        """
        return self._motion.is_done(self._simulation.core.time)

    @property
    def _path_time(self) -> float:
        return self._motion.progress(self._simulation.core.time)[1]

    def _rest(self) -> StepCoroutine[None]:
        while not self.is_done:
            yield
