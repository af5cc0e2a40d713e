"""Programs of steps: checks and runs of programs, and the related requests."""

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
    """Numbers of the loops around the step, and the number of the step, counted from 1;
    empty if the problem concerns the whole program."""
    text: str
    """Description of the problem and its remedy."""
    line: int | None = None
    """Line number of the step in the file, counted from 1; null if there is no file."""


class PlannedMotion(Struct, frozen=True, kw_only=True):
    """Motion of the arm in a program, for a preview."""

    joint_names: tuple[str, ...]
    """Names of the arm's joints, from base to flange."""
    times: tuple[float, ...]
    """Times since the start of the first motion [s], without waits and gripper
    motions."""
    positions: tuple[tuple[float, ...], ...]
    """Positions of the joints at these times [rad]."""
    points: tuple[tuple[float, float, float], ...]
    """Positions of the program's tool at these times, in the robot's root frame [m]."""
    steps: tuple[StepPath, ...]
    """For each of these times, the step that moves the arm up to this time."""


class ProgramCheck(Struct, frozen=True, kw_only=True):
    """Result of the check of a program."""

    problems: tuple[ProgramProblem, ...]
    """Problems that prevent execution; empty if the program can be executed from the
    current posture."""
    warnings: tuple[ProgramProblem, ...]
    """Deviations from the program, such as a smaller blend or a slower move."""
    motion: PlannedMotion
    """Planned motion up to the first problem.  The motion contains one iteration of
    each loop, and the whole distance of a move until contact."""


class ProgramRun(Struct, frozen=True, kw_only=True):
    """State of the last program of an arm: its progress, or its end."""

    run: int
    """Number of the run, counted from 1."""
    program: str
    """Name of the program."""
    arm: str
    """Name of the arm that the program moves."""
    state: RunState
    """State of the run.  ``stopped``: a request ended the program.  ``failed``: an
    error in a step ended the program."""
    step: StepPath = ()
    """Numbers of the current or last executed step; empty before the first step."""
    text: str = ""
    """Description of the current or last executed step."""
    error: str = ""
    """Reason why the program failed or was stopped; empty otherwise."""
    time: float = 0.0
    """Simulated time since the start of the program [s]."""


class SavedProgram(Struct, frozen=True, kw_only=True):
    """A program that was saved with the robot."""

    name: str
    """Name under which the program is saved."""
    n_steps: int
    """Number of steps, including the steps in loops; 0 if the program cannot be
    read."""
    error: str = ""
    """Reason why the program cannot be read; empty if it can be read."""


LONGEST_TEXT = 1_000_000
"""Maximum length of a program's file [characters]."""

ProgramFormat = Literal["yaml", "python", "urscript"]


class CheckProgram(Request[ProgramCheck], frozen=True):
    """Check and plan a program from the current posture, without moving the robot."""

    program: Program


class ParseProgram(Request[Program], frozen=True):
    """Parse the YAML of a program; an error contains the line number."""

    text: Annotated[str, Meta(max_length=LONGEST_TEXT)]


class ExportProgram(Request[str], frozen=True):
    """Export a program as YAML, or as a Python or URScript program."""

    program: Program
    format: ProgramFormat
    """Format of the output: ``yaml`` is the program's file, ``python`` is a script for
    tool0's API, and ``urscript`` is a program for a UR's control box."""


class RunProgram(Request[GoalStarted], frozen=True):
    """Check a program and run it.

    The program takes the arm from its controllers, and releases it at the end.  The
    goal ends when the program ends; the goal number is the negated run number.
    """

    program: Program | None = None
    name: Name | None = None
    """Name of a saved program, instead of ``program``."""
    paused: bool = False
    """Whether the program is paused before its first step, until ``step_run`` or
    ``resume_run``."""


class _OfRun(Request[Response], Generic[Response], frozen=True):
    """Common field of requests to a running program."""

    arm: Name | None = None
    """Name of the arm that the program moves; required only if several programs are
    running."""


class PauseRun(_OfRun[None], frozen=True):
    """Pause a program: the arm decelerates to rest on its path."""


class ResumeRun(_OfRun[None], frozen=True):
    """Continue a paused program."""


class StepRun(_OfRun[None], frozen=True):
    """Continue a paused program until the next step is finished."""


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
    """Whether to replace a saved program with the same name; otherwise, the request
    fails."""


class RenameProgram(Request[None], frozen=True):
    """Rename a saved program."""

    name: Name
    new_name: Name


class DeleteProgram(Request[None], frozen=True):
    """Delete a saved program."""

    name: Name
