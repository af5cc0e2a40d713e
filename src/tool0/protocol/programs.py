"""Programs of steps: their checks and runs, and the related requests."""

from __future__ import annotations

from typing import Annotated, Generic, Literal

from msgspec import Meta, Struct

from tool0.protocol.goals import GoalStarted
from tool0.protocol.program import Program, StepPath
from tool0.protocol.request import Name, Request, Response

RunState = Literal["running", "paused", "succeeded", "failed", "stopped"]

ENDED: frozenset[RunState] = frozenset({"succeeded", "failed", "stopped"})


class ProgramProblem(Struct, frozen=True, kw_only=True):
    """A problem in a program, with its location."""

    step: StepPath
    """Numbers of the loops around the step and of the step itself, from 1 on; empty if
    the problem concerns the whole program."""
    text: str
    """Description of the problem and its remedy."""
    line: int | None = None
    """Line in the file, counted from 1."""


class PlannedMotion(Struct, frozen=True, kw_only=True):
    """Motion of a program's arm, for a preview."""

    joint_names: tuple[str, ...]
    """Names of the arm's joints, from base to flange."""
    times: tuple[float, ...]
    """Times since the start of the first motion [s], excluding waits and grips."""
    positions: tuple[tuple[float, ...], ...]
    """Positions of the joints at these times [rad]."""
    points: tuple[tuple[float, float, float], ...]
    """Positions of the program's tool at these times, in the robot's root [m]."""
    steps: tuple[StepPath, ...]
    """Step that moves the arm up to each of these times."""


class ProgramCheck(Struct, frozen=True, kw_only=True):
    """Result of checking a program."""

    problems: tuple[ProgramProblem, ...]
    """Problems; empty if the program can be executed from the current posture."""
    warnings: tuple[ProgramProblem, ...]
    """Deviations from the program, such as a smaller blend or a slower move."""
    motion: PlannedMotion
    """Motion up to the first problem.  Each loop is planned for one iteration; a move
    until contact covers its whole distance."""


class ProgramRun(Struct, frozen=True, kw_only=True):
    """The last program of an arm: its progress, or how it ended."""

    run: int
    """Number of the run, counted from 1."""
    program: str
    """Name of the program."""
    arm: str
    """Name of the arm that the program moves."""
    state: RunState
    """State of the run; ``stopped``: ended from outside, ``failed``: ended by a
    step."""
    step: StepPath = ()
    """Numbers of the step that is being executed, or was last; empty before the
    first."""
    text: str = ""
    """Description of that step."""
    error: str = ""
    """Reason why the program failed or was stopped."""
    time: float = 0.0
    """Simulated time since the program's start [s]."""


class SavedProgram(Struct, frozen=True, kw_only=True):
    """A program that was saved with the robot."""

    name: str
    """Name under which the program is saved."""
    n_steps: int
    """Number of steps, including those in loops; 0 if it cannot be read."""
    error: str = ""
    """Reason why the program cannot be read."""


LONGEST_TEXT = 1_000_000
"""Maximum length of a program's file [characters]."""

ProgramFormat = Literal["yaml", "python", "urscript"]


class CheckProgram(Request[ProgramCheck], frozen=True):
    """Check and plan a program from the current posture; nothing moves."""

    program: Program


class ParseProgram(Request[Program], frozen=True):
    """Parse a program's YAML file; errors include the line."""

    text: Annotated[str, Meta(max_length=LONGEST_TEXT)]


class ExportProgram(Request[str], frozen=True):
    """Export a program as its YAML file, or as a Python or URScript program."""

    program: Program
    format: ProgramFormat
    """``yaml`` is the program's file, ``python`` a script for tool0's API, and
    ``urscript`` a program for a UR's control box."""


class RunProgram(Request[GoalStarted], frozen=True):
    """Check a program and run it.

    The program takes the arm from its controllers and releases it at the end.  The goal
    ends with the program; the goal's number is minus the run's number.
    """

    program: Program | None = None
    name: Name | None = None
    """Name of a saved program, instead of a program."""
    paused: bool = False
    """Whether the program waits for ``step_run`` or ``resume_run`` before its first
    step."""


class _OfRun(Request[Response], Generic[Response], frozen=True):
    """Common field of requests to a running program."""

    arm: Name | None = None
    """Name of the arm whose program is meant; may be left out if only one is
    running."""


class PauseRun(_OfRun[None], frozen=True):
    """Pause a program: the arm decelerates to a standstill on its path."""


class ResumeRun(_OfRun[None], frozen=True):
    """Continue a paused program."""


class StepRun(_OfRun[None], frozen=True):
    """Continue a paused program until its next step is done."""


class StopRun(_OfRun[None], frozen=True):
    """End a program: the arm stops on its path, and its controllers are restarted."""

    is_urgent = True
    revokes = ("run_program", "resume_run", "step_run")


class ReadRuns(Request[tuple[ProgramRun, ...]], frozen=True):
    """Read the state of each arm's last program."""


class ListPrograms(Request[tuple[SavedProgram, ...]], frozen=True):
    """List the programs that were saved with this robot."""


class ReadProgram(Request[Program], frozen=True):
    """Read a saved program."""

    name: Name


class SaveProgram(Request[None], frozen=True):
    """Save a program under its name, on the simulation's machine."""

    program: Program
    overwrite: bool = True
    """Whether to replace a saved program of that name; otherwise, this is an error."""


class RenameProgram(Request[None], frozen=True):
    """Rename a saved program."""

    name: Name
    new_name: Name


class DeleteProgram(Request[None], frozen=True):
    """Delete a saved program."""

    name: Name
