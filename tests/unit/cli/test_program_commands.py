"""``tool0 run`` and ``tool0 program`` with a robot that runs, over its socket."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import tool0
from tool0.cli import FAILED, GOAL_FAILED, INTERRUPTED, OK, main

Capture = pytest.CaptureFixture[str]
PICK = """\
name: wave
steps:
  - {kind: gripper, opening: 0.04}
  - {kind: move_joint, named_pose: home}
  - {kind: wait, duration: 0.1}
"""
ENDLESS = "name: wait\nsteps:\n  - {kind: loop, steps: [{kind: wait, duration: 0.1}]}\n"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "wave.yaml"
    path.write_text(PICK)
    return path


def run(*words: object) -> int:
    return main([str(word) for word in words])


def test_a_program_is_run_and_its_steps_are_shown(
    robot: tool0.Robot, file: Path, capsys: Capture
) -> None:
    assert run("run", file) == OK
    *_, last = capsys.readouterr().out.splitlines()
    assert last.startswith("succeeded after ")
    assert robot.gripper.opening == pytest.approx(0.04, abs=2e-3)


def test_a_dry_run_moves_nothing(
    robot: tool0.Robot, file: Path, capsys: Capture
) -> None:
    before = robot.gripper.opening
    assert run("run", file, "--dry-run") == OK
    printed = capsys.readouterr().out
    assert "dry run: succeeded after" in printed
    assert "largest speed: " in printed
    assert "largest effort: shoulder_lift_joint" in printed
    assert run("run", file, "--dry-run", "--json") == OK
    found = json.loads(capsys.readouterr().out)
    assert found["end"]["state"] == "succeeded"
    assert found["touches"] == []
    assert robot.gripper.opening == pytest.approx(before, abs=1e-4)
    assert run("run", file, "--dry-run", "--check") == FAILED
    assert "not both" in capsys.readouterr().err


def test_a_check_moves_nothing(robot: tool0.Robot, file: Path, capsys: Capture) -> None:
    before = robot.gripper.opening
    assert run("run", file, "--check") == OK
    assert "can be executed; its motions take" in capsys.readouterr().out
    assert robot.gripper.opening == pytest.approx(before, abs=1e-3)


def test_a_wrong_step_is_reported_with_file_and_line(
    robot: tool0.Robot, file: Path, capsys: Capture
) -> None:
    file.write_text(PICK.replace("home", "hmoe"))
    assert run("run", file, "--check") == GOAL_FAILED
    expected = f"{file}:4: error: step 2: unknown pose 'hmoe'; did you mean 'home'?\n"
    assert capsys.readouterr().out == expected
    assert run("run", file) == 2
    error = capsys.readouterr().err
    assert f"{file}:4: step 2: unknown pose 'hmoe'" in error
    file.write_text(PICK.replace("opening", "openng"))
    assert run("run", file) == 2
    assert f"{file}:3: " in capsys.readouterr().err


def test_a_program_that_fails_says_why(
    robot: tool0.Robot, file: Path, capsys: Capture
) -> None:
    file.write_text(PICK.replace("0.04}", "closed, must_hold: true}"))
    assert run("run", file) == GOAL_FAILED
    *_, last = capsys.readouterr().out.splitlines()
    assert last.startswith("failed after ")
    assert last.endswith("step 1: the gripper holds nothing: it is 'at_target'")


def test_programs_are_saved_listed_run_exported_and_deleted(
    robot: tool0.Robot, file: Path, capsys: Capture
) -> None:
    assert run("program", "save", file, "--as-name", "hello") == OK
    assert run("program", "list") == OK
    assert "hello  3 steps" in capsys.readouterr().out
    capsys.readouterr()
    assert run("program", "list", "--json") == OK
    assert json.loads(capsys.readouterr().out) == {
        "programs": [{"name": "hello", "n_steps": 3, "error": ""}]
    }
    assert run("run", "hello", "--check", "--json") == OK
    check = json.loads(capsys.readouterr().out)
    assert check == {"problems": [], "warnings": [], "duration": 0.0}
    assert run("run", "hello", "--json") == OK
    assert json.loads(capsys.readouterr().out)["state"] == "succeeded"
    script = file.with_suffix(".py")
    assert (
        run("program", "export", "hello", "--format", "python", "--output", script)
        == OK
    )
    compile(script.read_text(), str(script), "exec")
    capsys.readouterr()
    assert run("program", "export", "hello") == OK
    assert capsys.readouterr().out.startswith("format: 1\nname: hello\n")
    assert run("program", "delete", "hello") == OK
    assert run("run", "hello") == 2
    assert "no program 'hello' is saved" in capsys.readouterr().err


@pytest.mark.slow
def test_ctrl_c_stops_the_program(robot: tool0.Robot, file: Path) -> None:
    file.write_text(ENDLESS)
    command = [sys.executable, "-m", "tool0", "run", str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert "wait 0.1 s" in process.stdout.readline()
        process.send_signal(signal.SIGINT)
        rest = process.stdout.read()
    assert process.returncode == INTERRUPTED
    assert rest.startswith("stopped after ")
    assert not robot.arm.control_box.state.taken_by


def test_a_handle_from_another_process_pauses_and_steps(robot: tool0.Robot) -> None:
    program = tool0.Program(
        name="two waits",
        steps=(tool0.WaitStep(duration=0.05), tool0.WaitStep(duration=0.05)),
    )
    with tool0.connect() as other:
        handle = other.run_program(program, paused=True)
        wait = other.channel.wait_until
        assert wait(lambda: handle.status.state == "paused", 20.0)
        assert handle.status.step == (1,)
        handle.step()
        assert wait(lambda: handle.status.step == (2,), 20.0)
        assert wait(lambda: handle.status.state == "paused", 20.0)
        handle.resume()
        assert handle.wait(20.0).state == "succeeded"
        with pytest.raises(tool0.ProgramError, match="step 1: a wait needs"):
            other.run_program(tool0.Program(name="no", steps=(tool0.WaitStep(),)))
