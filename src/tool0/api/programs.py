"""Programs of steps: saved programs, checks, and the handle for a running program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, final

from msgspec.structs import replace

from tool0.api.controller import GoalHandle
from tool0.errors import ProgramError, RequestError, SourceLocation
from tool0.programs.files import ProgramFile, read_program
from tool0.protocol.channel import Channel
from tool0.protocol.program import Program, path_text
from tool0.protocol.programs import (
    CheckProgram,
    DeleteProgram,
    ExportProgram,
    ListPrograms,
    PauseRun,
    ProgramCheck,
    ProgramRun,
    ReadProgram,
    ReadRuns,
    RenameProgram,
    ResumeRun,
    RunProgram,
    SavedProgram,
    SaveProgram,
    StepRun,
)

if TYPE_CHECKING:
    from tool0.api.dry_run import DryRun

AnyProgram = Program | Path | str
"""A program, the path of its file, or the name of a saved program."""
_SUFFIXES = (".yaml", ".yml")


@final
class Programs:
    """The programs that were saved with a robot."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel

    def list(self) -> Sequence[SavedProgram]:
        """Return the saved programs, sorted by name."""
        return self._channel.call(ListPrograms())

    def read(self, program: AnyProgram) -> Program:
        """Return a program from a file, or a saved program.

        Raises:
            ControlError: If no program is saved under this name.
            ConfigError: If the file cannot be read, or is not a program.
        """
        return self._read(program).program

    def save(self, program: Program, *, overwrite: bool = True) -> None:
        """Save a program under its name.

        Raises:
            ControlError: If a program with this name exists and ``overwrite`` is false,
                or if the name is not printable.
            ConfigError: If the program cannot be written.
        """
        self._channel.call(SaveProgram(program=program, overwrite=overwrite))

    def rename(self, name: str, new_name: str) -> None:
        """Rename a saved program."""
        self._channel.call(RenameProgram(name=name, new_name=new_name))

    def delete(self, name: str) -> None:
        """Delete a saved program."""
        self._channel.call(DeleteProgram(name=name))

    def check(self, program: AnyProgram) -> ProgramCheck:
        """Check a program: plan it from the current posture without moving the robot.

        For a file, the problems and the warnings contain line numbers.
        """
        source = self._read(program)
        found = self._channel.call(CheckProgram(program=source.program))
        return replace(
            found,
            problems=tuple(map(source.located, found.problems)),
            warnings=tuple(map(source.located, found.warnings)),
        )

    def dry_run(
        self,
        program: AnyProgram,
        *,
        timeout: float = 3600.0,
        when_passed: Callable[[ProgramRun], None] = lambda run: None,
    ) -> DryRun:
        """Run a program in a simulation that starts at the robot's current state.

        The simulated robot has the current posture, objects and speed sliders.  An
        object that a gripper holds may slip out of the simulated gripper.  No command
        is sent to the robot.

        Args:
            program: The program, its file (``.yaml``), or the name of a saved program.
            timeout: Simulated time after which the program is stopped [s].
            when_passed: Called with the state of the run every 0.02 simulated seconds.

        Raises:
            ProgramError: If a step cannot be executed.
            ConfigError: If the file cannot be read, or is not a program.
            ControlError: If no program is saved under this name.
        """
        from tool0.api.dry_run import dry_run

        source = self._read(program)
        try:
            return dry_run(
                self._channel,
                source.program,
                timeout=timeout,
                when_passed=when_passed,
            )
        except ProgramError:
            self._explain(source)
            raise

    def export(
        self, program: AnyProgram, format: Literal["yaml", "python", "urscript"]
    ) -> str:
        """Return a program as YAML, or as an equivalent Python or URScript program.

        Raises:
            ControlError: If the language cannot express a step.
        """
        source = self._read(program)
        return self._channel.call(ExportProgram(program=source.program, format=format))

    def run(self, program: AnyProgram, *, paused: bool = False) -> ProgramHandle:
        """Start a program; see ``Robot.run_program``."""
        source = self._read(program)
        request = RunProgram(program=source.program, paused=paused)
        try:
            started = self._channel.call(request)
        except ProgramError:
            self._explain(source)
            raise
        return ProgramHandle(
            GoalHandle(started, self._channel), self._channel, -started.goal
        )

    def _explain(self, source: ProgramFile) -> None:
        """Raise ProgramError with the problems in a file and their line numbers."""
        if source.file is None:
            return
        problems = self.check(source.program).problems
        lines = [
            f"{SourceLocation(source.file, problem.line)}: step "
            f"{path_text(problem.step)}: {problem.text}"
            for problem in map(source.located, problems)
            if problem.step
        ]
        if lines:
            raise ProgramError("\n".join(lines)) from None

    def _read(self, program: AnyProgram) -> ProgramFile:
        if isinstance(program, str) and not program.endswith(_SUFFIXES):
            saved = self._channel.call(ReadProgram(name=program))
            return ProgramFile(program=saved, file=None, lines={})
        if isinstance(program, str | Path):
            return read_program(Path(program))
        if not isinstance(program, Program):
            problem = (
                f"'program': need a Program, a file or a name, got {program!r:.80}"
            )
            raise RequestError("run_program", problem)
        return ProgramFile(program=program, file=None, lines={})


@final
class ProgramHandle:
    """Handle for a running program, to wait for, pause, step or stop it."""

    def __init__(self, goal: GoalHandle, channel: Channel, run: int) -> None:
        self._goal, self._channel, self._run = goal, channel, run
        self._last = self.status

    @property
    def status(self) -> ProgramRun:
        """Current state of the program, including the current step and any error."""
        runs = self._channel.call(ReadRuns())
        found = next((item for item in runs if item.run == self._run), None)
        if found is not None:
            self._last = found
        return self._last

    def wait(self, timeout: float | None = None) -> ProgramRun:
        """Wait until the program has ended, and return its final state.

        For ``timeout``, see ``GoalHandle.wait``.

        Raises:
            GoalTimeoutError: If the program is still running after ``timeout``.
        """
        self._goal.wait(timeout)
        return self.status

    def pause(self) -> None:
        """Pause the program: the arm decelerates to rest on its path."""
        self._channel.call(PauseRun(arm=self._last.arm))

    def resume(self) -> None:
        """Continue the paused program."""
        self._channel.call(ResumeRun(arm=self._last.arm))

    def step(self) -> None:
        """Continue the program until the next step is finished."""
        self._channel.call(StepRun(arm=self._last.arm))

    def stop(self) -> None:
        """End the program: the arm stops on its path; its controllers are restarted.

        A program that has already ended is not changed.
        """
        self._goal.cancel()

    def __repr__(self) -> str:
        return f"ProgramHandle({self._last.program!r}, {self._last.state!r})"
