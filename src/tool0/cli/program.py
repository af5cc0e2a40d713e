"""``tool0 run`` and ``tool0 program``: programs of steps, on a running bringup."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

from tool0.cli import GOAL_FAILED, INTERRUPTED, OK
from tool0.cli.connection import DEFAULT, Bringup
from tool0.cli.parameters import AsJson, Option
from tool0.cli.text import columns, counted, print_json
from tool0.errors import ConfigError

if TYPE_CHECKING:
    from tool0.api.dry_run import DryRun
    from tool0.api.programs import ProgramHandle
    from tool0.api.robot import Robot
    from tool0.cli.outputs import ProgramCheckOutput, ProgramsOutput
    from tool0.protocol.programs import ProgramCheck, ProgramProblem, ProgramRun

Source = Annotated[str, Option(is_positional=True, metavar="FILE | PROGRAM")]
ProgramName = Annotated[str, Option(is_positional=True, metavar="PROGRAM")]

_POLL_PERIOD: Final = 0.05
"""Time between two checks of the program [wall s]."""
_STOP_TIMEOUT: Final = 10.0
"""Longest wait for a stopped program to end [wall s]."""


def run(
    program: Source,
    *,
    check: bool = False,
    dry_run: bool = False,
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> int:
    """Run a program until it ends, and print its steps.

    The program is checked first: if a step cannot be executed, the robot does not move.
    Ctrl-C stops the program.  The exit status is 0 if the program succeeded.

    Args:
        program: Program file (.yaml), or the name of a saved program.
        check: Only check the program, and do not execute it.
        dry_run: Only simulate the program, from the robot's current state; print the
            contacts, the duration, and the largest speed and effort.  No command is
            sent to the robot.  The exit status is 0 if the program succeeded and no arm
            collided.
        as_json: Do not print the steps; print one JSON object at the end.
    """
    if check and dry_run:
        raise ConfigError("give --check or --dry-run, not both")
    with bringup.connect() as robot:
        if dry_run:
            return _dry_run(robot, program, as_json=as_json)
        if not check:
            return _follow(robot, program, as_json=as_json)
        found = robot.programs.check(program)
    if as_json:
        print_json(_plain_check(found))
    else:
        _print_check(program, found)
    return GOAL_FAILED if found.problems else OK


def _dry_run(robot: Robot, program: str, *, as_json: bool) -> int:
    """Simulate a program separately from the robot, and print the results."""
    shown: tuple[object, ...] = ()

    def when_passed(run: ProgramRun) -> None:
        nonlocal shown
        shown = shown if as_json else _show(run, shown)

    found = robot.programs.dry_run(program, when_passed=when_passed)
    if as_json:
        print_json(found)
    else:
        _print_dry_run(found)
    has_succeeded = found.end.state == "succeeded" and not found.has_collided
    return OK if has_succeeded else GOAL_FAILED


def _print_dry_run(found: DryRun) -> None:
    end = found.end
    reason = f": {end.error}" if end.error else ""
    print(f"dry run: {end.state} after {end.time:.1f} s{reason}")
    for what, most, unit in (
        ("speed", found.speed, "rad/s"),
        ("effort", found.effort, "N·m"),
    ):
        print(
            f"largest {what}: {most.joint}, {most.value:.3g} {unit}, "
            f"{most.share:.0%} of its limit"
        )
    for touch in found.touches:
        kind = "collision" if touch.is_of_arm else "contact"
        print(
            f"{kind}: '{touch.first}' touches '{touch.second}' after "
            f"{touch.time:.2f} s, with up to {touch.force:.0f} N"
        )


def _plain_check(found: ProgramCheck) -> ProgramCheckOutput:
    return {
        "problems": found.problems,
        "warnings": found.warnings,
        "duration": _duration(found),
    }


def _duration(found: ProgramCheck) -> float:
    """Return the duration of the motions [s]."""
    return found.motion.times[-1] if found.motion.times else 0.0


def _print_check(name: str, found: ProgramCheck) -> None:
    for kind, problems in (("warning", found.warnings), ("error", found.problems)):
        for problem in problems:
            print(_problem(name, kind, problem))
    if not found.problems:
        duration = f"{_duration(found):.1f} s"
        print(f"{name}: can be executed; its motions take {duration}")


def _problem(name: str, kind: str, problem: ProgramProblem) -> str:
    from tool0.protocol.program import path_text

    where = name if problem.line is None else f"{name}:{problem.line}"
    step = f"step {path_text(problem.step)}: " if problem.step else ""
    return f"{where}: {kind}: {step}{problem.text}"


def _follow(robot: Robot, program: str, *, as_json: bool) -> int:
    """Run a program until it ends, or until a signal stops it."""
    from tool0.cli.stop_signal import StopSignal
    from tool0.errors import GoalTimeoutError

    with StopSignal() as stop:
        handle = robot.run_program(program)
        shown: tuple[object, ...] = ()
        while True:
            shown = shown if as_json else _show(handle.status, shown)
            try:
                end = handle.wait(_POLL_PERIOD)
                break
            except GoalTimeoutError:
                if not stop.is_set:
                    continue
            end = _stopped(handle)
            break
    if as_json:
        print_json(end)
    else:
        _show(end, shown)
        reason = f": {end.error}" if end.error else ""
        print(f"{end.state} after {end.time:.1f} s{reason}")
    if stop.is_set:
        return INTERRUPTED
    return OK if end.state == "succeeded" else GOAL_FAILED


def _stopped(handle: ProgramHandle) -> ProgramRun:
    handle.stop()
    return handle.wait(_STOP_TIMEOUT)


def _show(run: ProgramRun, shown: tuple[object, ...]) -> tuple[object, ...]:
    """Print the step unless it is already ``shown``; return the last printed step."""
    from tool0.protocol.program import path_text

    state = "paused" if run.state == "paused" else ""
    now = run.step, state
    if now != shown and run.step:
        pause = "  (paused)" if state else ""
        print(f"{path_text(run.step):>6}  {run.text}{pause}", flush=True)
    return now


def show(*, as_json: AsJson = False, bringup: Bringup = DEFAULT) -> None:
    """List the robot's saved programs.

    Args:
        as_json: Print one JSON object.
    """
    with bringup.connect() as robot:
        saved = robot.programs.list()
    if as_json:
        listed: ProgramsOutput = {"programs": saved}
        print_json(listed)
        return
    rows = [(item.name, item.error or counted(item.n_steps, "step")) for item in saved]
    print(columns([("name", "content"), *rows]), end="")


def save(
    program: Annotated[Path, Option(is_positional=True, metavar="FILE")],
    *,
    as_name: Annotated[str, Option(metavar="PROGRAM")] | None = None,
    bringup: Bringup = DEFAULT,
) -> None:
    """Add the program in a file to the robot's saved programs.

    Args:
        program: File of the program.
        as_name: Name of the saved program; the default is the name in the file.
    """
    from msgspec.structs import replace

    with bringup.connect() as robot:
        found = robot.programs.read(program)
        robot.programs.save(found if as_name is None else replace(found, name=as_name))


def delete(
    programs: Annotated[
        tuple[str, ...], Option(is_positional=True, metavar="PROGRAM ...")
    ],
    bringup: Bringup = DEFAULT,
) -> None:
    """Delete saved programs.

    Args:
        programs: Names of the programs.
    """
    with bringup.connect() as robot:
        for name in programs:
            robot.programs.delete(name)


def export(
    program: Source,
    *,
    format: Literal["yaml", "python", "urscript"] = "yaml",
    output: Path | None = None,
    bringup: Bringup = DEFAULT,
) -> None:
    """Write a program as YAML, or as an equivalent script.

    Args:
        program: File of the program, or the name of a saved program.
        format: Language of the output: ``python`` for tool0, ``urscript`` for a UR's
            control box.
        output: File to write; the default is standard output.
    """
    with bringup.connect() as robot:
        text = robot.programs.export(program, format)
    if output is None:
        sys.stdout.write(text)
    else:
        output.write_text(text, encoding="utf-8")


program = {"list": show, "save": save, "delete": delete, "export": export}
