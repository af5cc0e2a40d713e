"""Planning of a program before execution: every path from every possible posture.

Consecutive moves form one path, including the blends between them; comments between
moves are ignored.  A move until contact can end at any point of its path; therefore,
planning continues from both ends of the path.  A loop is planned until its start
postures repeat.  A path around obstacles is planned in the present scene, and is
planned again when the step begins.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple, TypeGuard, final

import numpy as np

from tool0.description.units import SPEED, require_plausible_angles
from tool0.errors import (
    CollisionError,
    ConfigError,
    ControlError,
    ModelError,
    PlanningError,
    UnreachableError,
    did_you_mean,
)
from tool0.kinematics.chain import Array
from tool0.motion.moves import Move, MoveError, MovePlan
from tool0.programs.robot_context import RobotContext
from tool0.protocol.program import (
    MOST_NESTED,
    MOST_STEPS,
    CommentStep,
    GripperStep,
    LoopStep,
    MoveJointStep,
    MoveLinearStep,
    MoveStep,
    PlaceObjectStep,
    Program,
    Step,
    StepPath,
    UntilStep,
    WaitStep,
    path_text,
    walk,
)
from tool0.protocol.programs import PlannedMotion, ProgramCheck, ProgramProblem

_REFUSALS: Final = (ControlError, ModelError, ConfigError)
"""Types of the errors that reject a step before planning."""
_SAME: Final = 1e-7
"""Distance below which two postures are treated as the same posture [rad]."""
_MOST_POSTURES: Final = 8
"""Maximum number of possible postures at the beginning of one step."""
_PREVIEW_STEP: Final = 0.02
"""Time between two points in the preview of a short program [s]."""
_MOST_POINTS: Final = 1500
"""Maximum number of points in a preview."""


class NumberedMove(NamedTuple):
    """A step that moves the arm, with the position of the step in the program."""

    path: StepPath
    step: MoveStep


def is_planned(step: Step) -> TypeGuard[MoveJointStep]:
    """Return whether the path of a step is planned around obstacles."""
    return isinstance(step, MoveJointStep) and step.plan


def moves_from(
    steps: Sequence[Step], first: int, parents: StepPath
) -> list[NumberedMove]:
    """Return the moves that form one path, starting at the index ``first``."""
    found = []
    for number, step in enumerate(steps[first:], first + 1):
        if isinstance(step, MoveStep) and not is_planned(step):
            found.append(NumberedMove((*parents, number), step))
        elif not isinstance(step, CommentStep):
            break
    return found


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ProgramPath:
    """A path of a program's arm that starts and ends at rest."""

    steps: tuple[StepPath, ...]
    """Positions of the path's steps in the program."""
    plan: MovePlan

    def is_from(self, step: StepPath, q: Sequence[float] | Array) -> bool:
        """Return whether the path begins with ``step`` at the posture ``q`` [rad]."""
        start = self.plan.path.positions[0]
        return self.steps[0] == step and bool(np.abs(start - q).max() < _SAME)


class _UnknownEndError(Exception):
    """Raised if the end of a step cannot be known before it begins."""


class StepError(Exception):
    """A step that cannot be planned."""

    def __init__(self, problem: ProgramProblem) -> None:
        super().__init__(problem.text)
        self.problem = problem


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ProgramPlan:
    """A program with all paths that can be planned in advance."""

    program: Program
    paths: tuple[ProgramPath, ...] = ()
    """Paths of the program, in the order of their first execution."""
    problems: tuple[ProgramProblem, ...] = ()
    warnings: tuple[ProgramProblem, ...] = ()

    def find(self, step: StepPath, q: Sequence[float]) -> ProgramPath | None:
        """Return the path that begins with ``step`` at ``q`` [rad], or None."""
        return next((path for path in self.paths if path.is_from(step, q)), None)

    def check(self, context: RobotContext) -> ProgramCheck:
        """Return the problems, and the motion for a preview."""
        return ProgramCheck(
            problems=self.problems,
            warnings=self.warnings,
            motion=preview(self.paths, context),
        )


def plan_program(context: RobotContext, start: Sequence[float]) -> ProgramPlan:
    """Plan a program that starts at rest at ``start`` [rad].

    The result contains the problems that were found.
    """
    program = context.program
    problems = static_problems(context)
    if problems:
        return ProgramPlan(program=program, problems=tuple(problems))
    planning = _Planning(context)
    try:
        planning.follow(program.steps, (), [np.array(start, dtype=np.float64)])
    except StepError as error:
        problems.append(error.problem)
    except _UnknownEndError:
        pass  # the remaining steps are planned when they begin; a warning reports this
    return ProgramPlan(
        program=program,
        paths=tuple(planning.paths),
        problems=tuple(problems),
        warnings=tuple(planning.warnings),
    )


def plan_path(
    context: RobotContext, moves: Sequence[NumberedMove], start: Sequence[float]
) -> ProgramPath:
    """Return the path of moves from rest at ``start`` [rad], or raise StepError."""
    steps = tuple(path for path, _ in moves)
    return _planned(context, steps, [context.move(step) for _, step in moves], start)


def plan_search(
    context: RobotContext, path: StepPath, step: UntilStep, start: Sequence[float]
) -> ProgramPath:
    """Return the full path of a move until contact, or raise StepError."""
    move = context.search(step, np.array(start, dtype=np.float64))
    return _planned(context, (path,), [move], start)


def plan_way(
    context: RobotContext, path: StepPath, step: MoveJointStep, start: Sequence[float]
) -> ProgramPath:
    """Return the path around obstacles that starts at rest at ``start`` [rad].

    Raises:
        StepError: If the target is out of reach.
        CollisionError: If the start or the target is in collision.
        PlanningError: If no path is found.
    """
    try:
        way = context.way(step, start)
    except UnreachableError as error:
        raise StepError(ProgramProblem(step=path, text=str(error))) from None
    plan = MovePlan(
        path=way, begins=(0.0,), zones=(way.duration,), warnings=(), tail=None
    )
    return ProgramPath(steps=(path,), plan=plan)


def _planned(
    context: RobotContext,
    steps: tuple[StepPath, ...],
    moves: Sequence[Move],
    start: Sequence[float],
) -> ProgramPath:
    try:
        plan = context.planner.plan(start, moves)
    except MoveError as error:
        step = steps[error.number - 1]
        raise StepError(ProgramProblem(step=step, text=error.reason)) from None
    return ProgramPath(steps=steps, plan=plan)


# ---- checks without planning ---------------------------------------------------------


def static_problems(context: RobotContext) -> list[ProgramProblem]:
    """Return the problems of individual steps, such as wrong names or values."""
    numbered = list(walk(context.program.steps))
    if len(numbered) > MOST_STEPS:
        text = f"the program has {len(numbered)} steps; {MOST_STEPS} is the most"
        return [ProgramProblem(step=(), text=text)]
    found = []
    if any(isinstance(step, MoveStep | UntilStep) for _, step in numbered):
        try:
            _ = context.planner
        except _REFUSALS as error:
            return [ProgramProblem(step=(), text=str(error))]
    for path, step in numbered:
        try:
            _check(context, path, step)
        except _REFUSALS as error:
            found.append(ProgramProblem(step=path, text=str(error)))
    return [*found, *_blends_into_ways(context.program.steps)]


def _blends_into_ways(
    steps: Sequence[Step], parents: StepPath = ()
) -> Iterator[ProgramProblem]:
    """Yield a problem for each blend into a path that must start at rest."""
    blended: StepPath | None = None
    for number, step in enumerate(steps, 1):
        path = (*parents, number)
        if isinstance(step, LoopStep):
            yield from _blends_into_ways(step.steps, path)
        if is_planned(step) and blended is not None:
            text = (
                f"step {path_text(path)} is planned from where this one rests: its "
                "'blend' must be 0"
            )
            yield ProgramProblem(step=blended, text=text)
        if not isinstance(step, CommentStep):
            is_blended = isinstance(step, MoveStep) and step.blend > 0.0
            blended = path if is_blended else None


def _check(context: RobotContext, path: StepPath, step: Step) -> None:
    """Raise one of the ``_REFUSALS`` if a single step is impossible."""
    if len(path) > MOST_NESTED + 1:
        raise ControlError(f"more than {MOST_NESTED} loops are within each other here")
    match step:
        case MoveJointStep(plan=True, blend=blend) if blend > 0.0:
            raise ControlError("a planned move ends at rest: its 'blend' must be 0")
        case MoveJointStep():
            context.move(step)
        case MoveLinearStep():
            SPEED.require_plausible(step.speed, "speed")
            context.move(step)
        case UntilStep():
            SPEED.require_plausible(step.speed, "speed")
            context.direction(step, np.eye(4))
        case GripperStep():
            context.opening(step)
        case WaitStep(duration=None, input=None):
            raise ControlError("a wait needs a 'duration' or an 'input'")
        case PlaceObjectStep(name=name) if name not in context.objects:
            hint = did_you_mean(name, context.objects)
            raise ControlError(f"there is no object '{name}'{hint}")
        case PlaceObjectStep():
            require_plausible_angles(step.rpy, "rpy")
        case LoopStep(times=int(), while_input=int()):
            raise ControlError("a loop has 'times' or 'while_input', not both")
        case LoopStep(steps=steps):
            if all(isinstance(item, CommentStep) for item in steps):
                raise ControlError("a loop needs a step that does something")


# ---- the paths -----------------------------------------------------------------------


@final
@dataclass(slots=True)
class _Planning:
    """Plans every path from every posture at which the path can begin."""

    context: RobotContext
    paths: list[ProgramPath] = field(default_factory=list)
    warnings: list[ProgramProblem] = field(default_factory=list)

    def follow(
        self, steps: Sequence[Step], parents: StepPath, starts: list[Array]
    ) -> list[Array]:
        """Return the possible end postures; empty if the steps never end."""
        index = 0
        while index < len(steps):
            step, path = steps[index], (*parents, index + 1)
            if not starts:
                self._warn(path, "is never reached: the loop before it is endless")
                return []
            if is_planned(step):
                starts = self._ways(path, step, starts)
            elif isinstance(step, MoveStep):
                moves = moves_from(steps, index, parents)
                starts = _distinct(self._path(moves, q).plan.end for q in starts)
                index = moves[-1].path[-1]
                continue
            elif isinstance(step, UntilStep):
                ends = [self._search(path, step, q).plan.end for q in starts]
                starts = _distinct([*ends, *starts])
            elif isinstance(step, LoopStep):
                starts = self._loop(step, path, starts)
            index += 1
        return starts

    def _loop(self, loop: LoopStep, path: StepPath, starts: list[Array]) -> list[Array]:
        ends = seen = self.follow(loop.steps, path, starts)
        while ends and loop.times != 1:
            ends = self.follow(loop.steps, path, ends)
            merged = _distinct([*seen, *ends])
            if len(merged) == len(seen) or len(merged) > _MOST_POSTURES:
                break
            seen = merged
        if loop.while_input is not None:
            return _distinct([*seen, *starts])
        return [] if loop.times is None else seen

    def _path(self, moves: Sequence[NumberedMove], q: Array) -> ProgramPath:
        first = moves[0].path
        known = next((path for path in self.paths if path.is_from(first, q)), None)
        if known is not None:
            return known
        return self._add(plan_path(self.context, moves, q.tolist()))

    def _ways(
        self, path: StepPath, step: MoveJointStep, starts: Sequence[Array]
    ) -> list[Array]:
        """Return the postures after a path around obstacles, in the present scene."""
        ends = []
        for q in starts:
            known = next((item for item in self.paths if item.is_from(path, q)), None)
            try:
                way = known or self._add(plan_way(self.context, path, step, q.tolist()))
            except (CollisionError, PlanningError) as error:
                self._warn(
                    path,
                    f"no way as the scene is now: {error}; it is planned again when "
                    "the step begins, and what follows is not checked before",
                )
            else:
                ends.append(way.plan.end)
        if not ends:
            raise _UnknownEndError
        return _distinct(ends)

    def _search(self, path: StepPath, step: UntilStep, q: Array) -> ProgramPath:
        known = next((item for item in self.paths if item.is_from(path, q)), None)
        if known is not None:
            return known
        return self._add(plan_search(self.context, path, step, q.tolist()))

    def _add(self, path: ProgramPath) -> ProgramPath:
        for warning in path.plan.warnings:
            step, text = path.steps[warning.number - 1], warning.text
            if warning.kind != "blend":
                self._warn(step, text)
                continue
            remedy = "choose smaller blends here or at the move before"
            raise StepError(ProgramProblem(step=step, text=f"{text}; {remedy}"))
        self.paths.append(path)
        return path

    def _warn(self, step: StepPath, text: str) -> None:
        warning = ProgramProblem(step=step, text=text)
        if warning not in self.warnings:
            self.warnings.append(warning)


def _distinct(postures: Iterable[Array]) -> list[Array]:
    """Return the postures without duplicates, in the given order."""
    found: list[Array] = []
    for q in postures:
        if all(np.abs(q - known).max() >= _SAME for known in found):
            found.append(q)
    return found[:_MOST_POSTURES]


# ---- the preview ---------------------------------------------------------------------


def preview(paths: Sequence[ProgramPath], context: RobotContext) -> PlannedMotion:
    """Return the motion along the first path of every step, in sequence."""
    shown: list[ProgramPath] = []
    for path in paths:
        if all(path.steps[0] != other.steps[0] for other in shown):
            shown.append(path)
    duration = sum(path.plan.duration for path in shown)
    spacing = max(_PREVIEW_STEP, duration / _MOST_POINTS)
    times: list[float] = []
    rows: list[list[float]] = []
    steps: list[StepPath] = []
    start = 0.0
    for path in shown:
        plan = path.plan
        if plan.duration == 0.0:
            continue
        n = max(2, round(plan.duration / spacing) + 1)
        grid = np.linspace(0.0, plan.duration, n)
        times += (start + grid).tolist()
        rows += plan.path.at(grid).positions.tolist()
        steps += [path.steps[plan.move_at(time)] for time in grid.tolist()]
        start += plan.duration
    points = context.tool(np.array(rows))[:, :3, 3].tolist() if rows else []
    return PlannedMotion(
        joint_names=context.joint_names,
        times=tuple(times),
        positions=tuple(tuple(row) for row in rows),
        points=tuple((x, y, z) for x, y, z in points),
        steps=tuple(steps),
    )


def problems_text(name: str, problems: Sequence[ProgramProblem]) -> str:
    """Return all problems as one message."""
    parts = [
        f"step {path_text(item.step)}: {item.text}" if item.step else item.text
        for item in problems
    ]
    return f"the program '{name}' cannot be executed: " + "; ".join(parts)
