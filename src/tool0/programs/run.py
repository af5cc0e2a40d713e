"""What is known of a program before, while and after it runs."""

from __future__ import annotations

from typing import Literal

from msgspec import Struct

from tool0.programs.model import StepPath

RunState = Literal["running", "paused", "succeeded", "failed", "stopped"]
ENDED: frozenset[RunState] = frozenset({"succeeded", "failed", "stopped"})


class ProgramProblem(Struct, frozen=True, kw_only=True):
    """Why a program cannot be executed."""

    step: StepPath
    """The numbers of the step and of the loops around it, from 1 on; empty if it is the
    program as a whole."""
    text: str
    """What is wrong, and what would be right."""
    line: int | None = None
    """Of the file, from 1 on."""


class PlannedMotion(Struct, frozen=True, kw_only=True):
    """The motion of a program's arm, for a preview."""

    joint_names: tuple[str, ...]
    """From base to flange."""
    times: tuple[float, ...]
    """Since the first motion [s], without what waits and grips take."""
    positions: tuple[tuple[float, ...], ...]
    """Of the joints at these times [rad]."""
    points: tuple[tuple[float, float, float], ...]
    """Of the program's tool at these times, in the robot's root [m]."""
    steps: tuple[StepPath, ...]
    """The step that moves the arm up to each of these times."""


class ProgramCheck(Struct, frozen=True, kw_only=True):
    """What a check of a program found; nothing moved."""

    problems: tuple[ProgramProblem, ...]
    """Empty if the program can be executed from the present posture."""
    warnings: tuple[ProgramProblem, ...]
    """What will be other than asked: a blend that is smaller, a slower move."""
    motion: PlannedMotion
    """Up to the first problem.  Each loop is planned once; a move until contact goes
    all its way."""


class ProgramRun(Struct, frozen=True, kw_only=True):
    """The last program of an arm: what it does, or how it ended."""

    run: int
    """Counts up from 1."""
    program: str
    """Its name."""
    arm: str
    """That it moves."""
    state: RunState
    """``stopped`` is ended by something else, ``failed`` by a step."""
    step: StepPath = ()
    """The one that is executed, or was the last; empty before the first."""
    text: str = ""
    """That step in words."""
    error: str = ""
    """Why it failed or was stopped."""
    time: float = 0.0
    """Simulated time since its start [s]."""


class SavedProgram(Struct, frozen=True, kw_only=True):
    """A program that was saved with the robot."""

    name: str
    """What it is saved under."""
    n_steps: int
    """Those within loops included; 0 if it cannot be read."""
    error: str = ""
    """Why it cannot be read."""
