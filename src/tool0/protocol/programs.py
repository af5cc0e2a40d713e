"""Programs of steps: what is known of them, and the requests to check and run them."""

from __future__ import annotations

from typing import Annotated, Generic, Literal

from msgspec import Meta, Struct

from tool0.protocol.goals import GoalStarted
from tool0.protocol.program import Program, StepPath
from tool0.protocol.request import Name, Request, Response

RunState = Literal["running", "paused", "succeeded", "failed", "stopped"]

ENDED: frozenset[RunState] = frozenset({"succeeded", "failed", "stopped"})


class ProgramProblem(Struct, frozen=True, kw_only=True):
    """Why a program cannot be executed."""

    step: StepPath
    """The numbers of the step and of the loops around it, from 1 on; empty if it is the
    program as a whole."""
    text: str
    """The problem and its remedy."""
    line: int | None = None
    """Line in the file, from 1 on."""


class PlannedMotion(Struct, frozen=True, kw_only=True):
    """The motion of a program's arm, for a preview."""

    joint_names: tuple[str, ...]
    """Names of the arm's joints, from base to flange."""
    times: tuple[float, ...]
    """Times since the first motion [s], without the durations of waits and grips."""
    positions: tuple[tuple[float, ...], ...]
    """Positions of the joints at these times [rad]."""
    points: tuple[tuple[float, float, float], ...]
    """Positions of the program's tool at these times, in the robot's root [m]."""
    steps: tuple[StepPath, ...]
    """The step that moves the arm up to each of these times."""


class ProgramCheck(Struct, frozen=True, kw_only=True):
    """The result of checking a program; nothing moved."""

    problems: tuple[ProgramProblem, ...]
    """Empty if the program can be executed from the present posture."""
    warnings: tuple[ProgramProblem, ...]
    """Differences from the request: a smaller blend, a slower move."""
    motion: PlannedMotion
    """Motion up to the first problem.  Each loop is planned once; a move until contact
    goes all its way."""


class ProgramRun(Struct, frozen=True, kw_only=True):
    """The last program of an arm: what it does, or how it ended."""

    run: int
    """Counts up from 1."""
    program: str
    """Name of the program."""
    arm: str
    """Name of the arm that the program moves."""
    state: RunState
    """``stopped`` is ended by something else, ``failed`` by a step."""
    step: StepPath = ()
    """The one that is executed, or was the last; empty before the first."""
    text: str = ""
    """Description of that step."""
    error: str = ""
    """Why it failed or was stopped."""
    time: float = 0.0
    """Simulated time since its start [s]."""


class SavedProgram(Struct, frozen=True, kw_only=True):
    """A program that was saved with the robot."""

    name: str
    """Name under which the program is saved."""
    n_steps: int
    """Number of steps, including those in loops; 0 if it cannot be read."""
    error: str = ""
    """Why it cannot be read."""


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

    The program takes the arm from its controllers, and releases it at the end.  The
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
    """Program that the run executes; the only one that runs, if left out."""


class PauseRun(_OfRun[None], frozen=True):
    """Pause a program: the arm slows down to a standstill on its path."""


class ResumeRun(_OfRun[None], frozen=True):
    """Continue a program that was paused."""


class StepRun(_OfRun[None], frozen=True):
    """Continue a program that was paused until its next step is done."""


class StopRun(_OfRun[None], frozen=True):
    """End a program: the arm stops on its path, and its controllers start again."""

    is_urgent = True
    revokes = ("run_program", "resume_run", "step_run")


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
