"""Handlers of the requests that check, run, save and export programs."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from tool0.description.parts import gripper_of
from tool0.errors import ControlError, ProgramError
from tool0.protocol.control_box import PauseProgram, PlayProgram
from tool0.protocol.goals import GoalStarted
from tool0.protocol.program import Program, require_shallow
from tool0.protocol.programs import (
    CheckProgram,
    DeleteProgram,
    ExportProgram,
    ListPrograms,
    ParseProgram,
    PauseRun,
    ProgramCheck,
    ReadProgram,
    ReadRuns,
    RenameProgram,
    ResumeRun,
    RunProgram,
    SaveProgram,
    StepRun,
    StopRun,
)
from tool0.simulation.handlers.motion_checks import motion_plans
from tool0.simulation.handlers.table import answer, handles
from tool0.simulation.loop import POLL_PERIOD
from tool0.simulation.simulation import Simulation

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tool0.description.model import Joint
    from tool0.motion.path import Path
    from tool0.programs.planning import ProgramPlan
    from tool0.programs.robot_context import RobotContext
    from tool0.protocol.planning import PlanTarget
    from tool0.simulation.handlers.program_run import ProgramExecution

_LONGEST_RETURN = 2.0
"""Longest wall time that a starting program waits for an arm that is being released
[s]."""


def _context(simulation: Simulation, program: Program) -> RobotContext:
    """Return the context of a program.

    ControlError is raised if the program's arm or gripper is unknown.
    """
    from tool0.programs.robot_context import RobotContext

    require_shallow(program)
    model, snapshot = simulation.description.model, simulation.snapshot
    chain = simulation.arm(program.arm)
    arm = next(name for name, known in simulation.arms.items() if known is chain)
    gripper = program.gripper or gripper_of(model, arm)

    def find_way(
        target: PlanTarget, start: Sequence[float], joints: Sequence[Joint]
    ) -> Path:
        names = (joint.name for joint in joints)
        now = {**simulation.snapshot.positions, **dict(zip(names, start, strict=True))}
        return motion_plans(simulation).way_around(target, now, joints)

    return RobotContext(
        program=program,
        model=model,
        arm=arm,
        tip=chain.tip,
        joints=simulation.core.arms.find(arm).motion.spec.joint_models,
        positions=snapshot.positions,
        find_pose=lambda name: simulation.poses.find(name).positions,
        find_way=find_way,
        gripper=gripper,
        geometry=None if gripper is None else simulation.gripper(gripper),
        objects=tuple(item.name for item in snapshot.scene),
    )


def _planned(simulation: Simulation, context: RobotContext) -> ProgramPlan:
    """Plan a program, starting at the current commanded positions of its arm."""
    from tool0.programs.planning import plan_program

    core = simulation.core
    motion = core.arms.find(context.arm).motion
    start = simulation.loop.call(lambda: motion.setpoint(core.state), publishes=False)
    return plan_program(context, start)


def _wait_for_return(simulation: Simulation, arm: str) -> None:
    """Wait for an arm that is being released, if the simulation runs in real time."""
    loop, bus = simulation.loop, simulation.bus
    motion = simulation.core.arms.find(arm).motion
    end = time.monotonic() + _LONGEST_RETURN
    while loop.is_realtime and time.monotonic() < end:
        is_ending = simulation.program_runs.is_ending(arm)
        if not (is_ending or motion.is_returning):
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
    from tool0.simulation.handlers.program_run import ProgramExecution

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

    runs, executor = simulation.program_runs, simulation.executor

    def start() -> GoalStarted:
        run = runs.start(context.arm, make)
        executor.when_goal_starts(run.goal)
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
handles(StopRun)(
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
