"""Requests about programs: check, run, save and export them."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated, Generic, Literal

from msgspec import Meta

from tool0.description.parts import gripper_of
from tool0.errors import ControlError, ProgramError
from tool0.programs.model import Program, require_shallow
from tool0.programs.run import ProgramCheck, ProgramRun, SavedProgram
from tool0.requests.control_box import PauseProgram, PlayProgram
from tool0.requests.motion import GoalStarted
from tool0.requests.table import Name, Request, Response, answer, handles
from tool0.runtime.loop import POLL_PERIOD
from tool0.runtime.simulation import Simulation

if TYPE_CHECKING:
    from tool0.programs.planning import ProgramPlan
    from tool0.programs.robot_context import RobotContext
    from tool0.requests.program_run import ProgramExecution

_LONGEST_RETURN = 2.0
"""Of an arm that is given back while a program is to begin [wall s]."""
LONGEST_TEXT = 1_000_000
"""Characters of a program's file."""

ProgramFormat = Literal["yaml", "python", "urscript"]


class CheckProgram(Request[ProgramCheck], frozen=True):
    """Plan a program from the present posture; nothing moves."""

    program: Program


class ParseProgram(Request[Program], frozen=True):
    """Read a program's file, YAML; the error says the line."""

    text: Annotated[str, Meta(max_length=LONGEST_TEXT)]


class ExportProgram(Request[str], frozen=True):
    """Write a program as its file, or in a language that does the same."""

    program: Program
    format: ProgramFormat
    """``python`` is a script for this API, ``urscript`` one for a UR's control box."""


class RunProgram(Request[GoalStarted], frozen=True):
    """Check a program, and run it.

    The program takes the arm from its controllers, and gives it back at the end.  The
    goal ends with the program; its number is the negative one of the run.
    """

    program: Program | None = None
    name: Name | None = None
    """Instead of a program: that of a saved one."""
    paused: bool = False
    """Whether it waits before its first step, for ``step_run`` or ``resume_run``."""


class _OfRun(Request[Response], Generic[Response], frozen=True):
    """The field of every request to a program that runs."""

    arm: Name | None = None
    """Whose program; the only one that runs, if left out."""


class PauseRun(_OfRun[None], frozen=True):
    """Pause a program: the arm slows down to a standstill on its path."""


class ResumeRun(_OfRun[None], frozen=True):
    """Continue a program that was paused."""


class StepRun(_OfRun[None], frozen=True):
    """Continue a program that was paused until its next step is done."""


class StopRun(_OfRun[None], frozen=True):
    """End a program: the arm stops on its path, and its controllers start again."""


class ReadRuns(Request[tuple[ProgramRun, ...]], frozen=True):
    """The last program of each arm."""


class ListPrograms(Request[tuple[SavedProgram, ...]], frozen=True):
    """The programs that were saved with this robot."""


class ReadProgram(Request[Program], frozen=True):
    """A saved program."""

    name: Name


class SaveProgram(Request[None], frozen=True):
    """Save a program under its name, on the simulation's machine."""

    program: Program
    overwrite: bool = True
    """Whether it replaces a saved one of that name; otherwise that is an error."""


class RenameProgram(Request[None], frozen=True):
    """Give a saved program another name."""

    name: Name
    new_name: Name


class DeleteProgram(Request[None], frozen=True):
    """Delete a saved program."""

    name: Name


def _context(simulation: Simulation, program: Program) -> RobotContext:
    """Return what a program finds; ControlError if its arm or gripper is unknown."""
    from tool0.programs.robot_context import RobotContext

    require_shallow(program)
    model, snapshot = simulation.description.model, simulation.snapshot
    chain = simulation.arm(program.arm)
    arm = next(name for name, known in simulation.arms.items() if known is chain)
    gripper = program.gripper or gripper_of(model, arm)
    return RobotContext(
        program=program,
        model=model,
        arm=arm,
        tip=chain.tip,
        joints=simulation.core.arm_motions.specs[arm].joint_models,
        positions=snapshot.positions,
        find_pose=lambda name: simulation.poses.find(name).positions,
        gripper=gripper,
        geometry=None if gripper is None else simulation.gripper(gripper),
        objects=tuple(item.name for item in snapshot.scene),
    )


def _planned(simulation: Simulation, context: RobotContext) -> ProgramPlan:
    """Plan a program from where its arm is commanded to be now."""
    from tool0.programs.planning import plan_program

    core, arm = simulation.core, context.arm
    start = simulation.loop.call(
        lambda: core.arm_motions.rest(arm, core.state), publishes=False
    )
    return plan_program(context, start)


def _wait_for_return(simulation: Simulation, arm: str) -> None:
    """Wait for an arm that stops in order to be given back, while time passes."""
    loop, bus, core = simulation.loop, simulation.bus, simulation.core
    end = time.monotonic() + _LONGEST_RETURN
    while loop.is_realtime and time.monotonic() < end:
        is_ending = simulation.program_runs.is_ending(arm)
        if not (is_ending or core.arm_motions.is_returning(arm)):
            return
        bus.newer_than(bus.latest, POLL_PERIOD)


@handles(CheckProgram)
def _check(simulation: Simulation, request: CheckProgram) -> ProgramCheck:
    context = _context(simulation, request.program)
    return _planned(simulation, context).check(context)


@handles(ParseProgram)
def _parse(simulation: Simulation, request: ParseProgram) -> Program:
    from tool0.programs.files import parse_program

    return parse_program(request.text).program


@handles(ExportProgram)
def _export(simulation: Simulation, request: ExportProgram) -> str:
    from tool0.programs.export import exported

    context = _context(simulation, request.program)
    return exported(context, request.format)


@handles(RunProgram)
def _run(simulation: Simulation, request: RunProgram) -> GoalStarted:
    from tool0.programs.planning import problems_text
    from tool0.requests.program_run import ProgramExecution

    program = request.program
    if (program is None) == (request.name is None):
        raise ControlError("run_program: give either a program or the name of one")
    if program is None:
        program = simulation.programs.read(str(request.name))
    context = _context(simulation, program)
    _wait_for_return(simulation, context.arm)
    plan = _planned(simulation, context)
    if plan.problems:
        raise ProgramError(problems_text(program.name, plan.problems))

    def make(number: int) -> ProgramExecution:
        return ProgramExecution(
            simulation, plan, context, number=number, paused=request.paused
        )

    runs, core = simulation.program_runs, simulation.core

    def start() -> GoalStarted:
        run = runs.start(context.arm, make)
        core.when_goal_starts(run.goal)
        number = simulation.goals.add(run.goal, -run.status.run)
        return GoalStarted(goal=number, controller=run.goal.controller)

    return simulation.loop.call(start)


@handles(PauseRun)
def _pause(simulation: Simulation, request: PauseRun) -> None:
    run = simulation.program_runs.find(request.arm)
    answer(simulation, PauseProgram(arm=run.status.arm))


def _continue(simulation: Simulation, request: ResumeRun | StepRun) -> None:
    run = simulation.program_runs.find(request.arm)
    run.set_stepping(isinstance(request, StepRun))
    answer(simulation, PlayProgram(arm=run.status.arm))


handles(ResumeRun)(_continue)
handles(StepRun)(_continue)
handles(StopRun, urgent=True, revokes=("run_program", "resume_run", "step_run"))(
    lambda sim, request: sim.program_runs.find(request.arm).stop("it was stopped")
)
handles(ReadRuns)(lambda sim, _: sim.program_runs.states)
handles(ListPrograms)(lambda sim, _: sim.programs.all())
handles(ReadProgram)(lambda sim, request: sim.programs.read(request.name))


@handles(SaveProgram)
def _save(simulation: Simulation, request: SaveProgram) -> None:
    require_shallow(request.program)
    simulation.programs.save(request.program, overwrite=request.overwrite)


handles(RenameProgram)(
    lambda sim, request: sim.programs.rename(request.name, request.new_name)
)
handles(DeleteProgram)(lambda sim, request: sim.programs.delete(request.name))
