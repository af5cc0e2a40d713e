"""Exported programs are executed: they do the same as the program itself."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from served import serving
from taught_programs import taught_pick
from urscript_export import TIMEOUT, run_urscript

import tool0
from tool0 import (
    CommentStep,
    GripperStep,
    LoopStep,
    MoveJointStep,
    MoveLinearStep,
    PlaceObjectStep,
    Program,
    SetOutputStep,
    ToolPose,
    UntilStep,
    WaitStep,
)

pytestmark = pytest.mark.slow

EVERY_STEP = Program(
    name='every "step"\n\\',
    arm="arm",
    tool=ToolPose(xyz=(0.0, 0.0, 0.14)),
    steps=(
        CommentStep(text='a "comment"\nin two lines'),
        MoveJointStep(label='a "label"\nin two lines', named_pose="home", blend=0.01),
        CommentStep(text="between two moves"),
        MoveLinearStep(pose=ToolPose(xyz=(0.45, 0.1, 0.06), rpy=(3.14, 0.0, 0.0))),
        LoopStep(
            times=2,
            steps=(
                GripperStep(opening=0.03, speed=0.1, force=30.0),
                LoopStep(while_input=2, steps=(WaitStep(duration=0.01),)),
                WaitStep(input=3, level=False, duration=1.0),
            ),
        ),
        PlaceObjectStep(name="cube", xyz=(0.6, 0.2, 0.0025)),
        GripperStep(opening="closed"),
        UntilStep(direction=(0.0, 0.0, -1.0), distance=0.2, speed=0.02),
        UntilStep(
            direction=(0.0, 0.0, -1.0),  # up again: a search that is blocked fails
            frame="tool",
            distance=0.01,
            force=500.0,
            must_touch=False,
        ),
        SetOutputStep(output=9),
        LoopStep(steps=(WaitStep(duration=0.05),)),
    ),
)


@pytest.fixture(scope="module")
def bringup() -> Iterator[tool0.Robot]:
    with (
        tool0.bringup(arm="ur5e", scene="table_and_bin", realtime=False) as robot,
        serving(robot),
    ):
        yield robot


@pytest.fixture
def robot(bringup: tool0.Robot) -> tool0.Robot:
    bringup.reset()
    bringup.run(0.02)
    return bringup


@contextmanager
def time_passing(robot: tool0.Robot) -> Iterator[None]:
    has_ended = threading.Event()

    def run() -> None:
        while not has_ended.is_set():
            robot.run(0.2)

    clock = threading.Thread(target=run)
    clock.start()
    try:
        yield
    finally:
        has_ended.set()
        clock.join()


def is_in_bin(robot: tool0.Robot) -> bool:
    box = tool0.find_bin(robot.scene.objects, "bin")
    return box.holds(robot.scene.pose("cube"))


def python(script: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-W", "error", str(script)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


def test_the_python_script_picks(robot: tool0.Robot, tmp_path: Path) -> None:
    script = tmp_path / "pick.py"
    script.write_text(robot.programs.export(taught_pick(robot), "python"))
    with time_passing(robot):
        done = python(script)
        assert done.communicate(timeout=TIMEOUT)[1] == ""
    assert done.returncode == 0
    assert is_in_bin(robot)


def test_the_python_script_executes_every_kind_of_step(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    box = robot.arm.control_box
    box.set_digital_output(9, False)
    script = tmp_path / "all.py"
    script.write_text(robot.programs.export(EVERY_STEP, "python"))
    with time_passing(robot):
        running = python(script)
        assert robot.channel.wait_until(lambda: box.state.digital_outputs[9], TIMEOUT)
        running.terminate()
        running.communicate(timeout=TIMEOUT)


def test_the_urscript_is_checked_without_an_error(robot: tool0.Robot) -> None:
    from tool0.ur.urscript.program import compile_program

    text = robot.programs.export(EVERY_STEP, "urscript")
    assert compile_program(text).name.startswith("program_every")
    assert "# 'cube' is placed in the simulation only" in text


def test_the_urscript_picks(robot: tool0.Robot) -> None:
    steps = (*taught_pick(robot).steps, SetOutputStep(output=9))
    with time_passing(robot):
        run_urscript(robot, Program(name="pick", steps=steps))
    assert is_in_bin(robot)


def test_the_urscript_rests_where_a_path_ends(robot: tool0.Robot) -> None:
    """With a blend, URScript goes on before the move has ended."""
    down = {"rpy": (3.14, 0.0, 0.0)}
    steps = (
        MoveLinearStep(pose=ToolPose(xyz=(0.4, 0.1, 0.3), **down), blend=0.05),
        CommentStep(text="on the way"),
        MoveLinearStep(pose=ToolPose(xyz=(0.4, 0.2, 0.3), **down), blend=0.05),
        SetOutputStep(output=1),
        LoopStep(
            times=1,
            steps=(
                MoveLinearStep(pose=ToolPose(xyz=(0.4, 0, 0.3), **down), blend=0.1),
            ),
        ),
    )
    text = robot.programs.export(Program(name="blends", steps=steps), "urscript")
    moves = [line for line in text.splitlines() if "movel(" in line]
    assert ["r=" in line for line in moves] == [True, False, False]


def test_yaml_is_the_file_of_the_program(robot: tool0.Robot, tmp_path: Path) -> None:
    file = tmp_path / "every.yaml"
    file.write_text(robot.programs.export(EVERY_STEP, "yaml"))
    assert robot.programs.read(file) == EVERY_STEP


def test_a_step_that_is_impossible_cannot_be_exported(robot: tool0.Robot) -> None:
    wrong = Program(name="wrong", steps=(MoveJointStep(named_pose="hmoe"),))
    with pytest.raises(tool0.ControlError, match="did you mean 'home'"):
        robot.programs.export(wrong, "urscript")
    for step in (WaitStep(), UntilStep(direction=(0, 0, 0), distance=0.1), LoopStep()):
        with pytest.raises(tool0.ProgramError, match="step 1: "):
            robot.programs.export(Program(name="wrong", steps=(step,)), "urscript")
    gone = Program(name="gone", steps=(PlaceObjectStep(name="gone", xyz=(0, 0, 0)),))
    assert "'gone' is placed" in robot.programs.export(gone, "urscript")
