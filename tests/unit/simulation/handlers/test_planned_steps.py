"""Steps of programs that go around obstacles, and programs that refuse to collide."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from taught_programs import TOOL, at

import tool0
from tool0 import (
    CommentStep,
    GripperStep,
    LoopStep,
    MoveJointStep,
    MoveLinearStep,
    Program,
    ToolPose,
    WaitStep,
)
from tool0.scene import Box

TIMEOUT = 60.0
"""[simulated s]"""
LEFT, RIGHT = at(0.4, 0.35, 0.3), at(0.4, -0.35, 0.3)


@pytest.fixture(scope="module")
def bringup() -> Iterator[tool0.Robot]:
    with tool0.bringup(arm="ur5e", scene="table_and_bin", realtime=False) as robot:
        yield robot


@pytest.fixture
def robot(bringup: tool0.Robot) -> Iterator[tool0.Robot]:
    """Return it with a wall in front of it, between left and right."""
    bringup.reset()
    bringup.scene.add("wall", Box(size=(0.4, 0.05, 0.35)), xyz=(0.5, 0.0, 0.165))
    bringup.run(0.02)
    yield bringup
    for name in ("wall", "late"):
        if name in bringup.scene:
            bringup.scene.remove(name)


def around(to: ToolPose, **options: float) -> MoveJointStep:
    return MoveJointStep(pose=to, plan=True, **{"speed": 2.0, **options})


def program(*steps: tool0.protocol.program.Step, **options: object) -> Program:
    return Program(name="p", steps=steps, **options)  # type: ignore[arg-type]


def touches(robot: tool0.Robot, name: str) -> bool:
    return any(name in (item.first, item.second) for item in robot.contacts())


@pytest.mark.slow
def test_a_planned_step_goes_around(robot: tool0.Robot) -> None:
    run = robot.run_program(program(around(LEFT), around(RIGHT), around(LEFT)))
    hit = False

    def is_over() -> bool:
        nonlocal hit
        hit = hit or touches(robot, "wall")
        return run.status.state != "running"

    assert robot.channel.wait_until(is_over, TIMEOUT)
    assert run.status.state == "succeeded", run.status.error
    assert not hit
    assert robot.arm.pose().position == pytest.approx(LEFT.xyz, abs=2e-3)


def test_its_speed_is_a_limit_of_each_joint(robot: tool0.Robot) -> None:
    run = robot.run_program(program(around(LEFT, speed=0.5)))
    fastest = 0.0

    def is_over() -> bool:
        nonlocal fastest
        fastest = max(fastest, *map(abs, robot.joint_state.velocity.values()))
        return run.status.state != "running"

    assert robot.channel.wait_until(is_over, TIMEOUT)
    assert run.status.state == "succeeded", run.status.error
    assert 0.45 < fastest < 0.55


@pytest.mark.slow
def test_it_carries_what_the_gripper_holds(robot: tool0.Robot) -> None:
    x, y, z = robot.scene.pose("cube").position
    tool = ToolPose(xyz=TOOL.xyz)
    end = robot.run_program(
        program(
            GripperStep(opening="open"),
            around(at(x, y, z + 0.1)),
            MoveLinearStep(pose=at(x, y, z)),
            GripperStep(opening="closed", must_hold=True),
            around(at(0.4, -0.15, 0.15)),
            tool=tool,
        )
    ).wait(TIMEOUT)
    assert end.state == "succeeded", end.error
    cube = robot.scene.pose("cube").position
    assert cube == pytest.approx((0.4, -0.15, 0.15), abs=0.02)


@pytest.mark.slow
def test_planned_steps_are_stepped_and_paused(robot: tool0.Robot) -> None:
    run = robot.run_program(program(around(LEFT), around(RIGHT)), paused=True)
    wait = robot.channel.wait_until
    assert wait(lambda: run.status.state == "paused", TIMEOUT)
    run.step()
    assert wait(lambda: run.status.step == (2,), TIMEOUT)
    assert wait(lambda: run.status.state == "paused", TIMEOUT)
    assert robot.arm.pose().position == pytest.approx(LEFT.xyz, abs=2e-3)
    run.resume()
    robot.run(0.5)
    run.pause()
    robot.run(0.5)
    assert run.status.state == "paused"
    assert max(map(abs, robot.joint_state.velocity.values())) < 0.01
    run.resume()
    assert run.wait(TIMEOUT).state == "succeeded"
    assert robot.arm.pose().position == pytest.approx(RIGHT.xyz, abs=2e-3)


def test_a_contact_that_is_not_expected_ends_the_program(robot: tool0.Robot) -> None:
    run = robot.run_program(program(around(LEFT), around(RIGHT, speed=1.0)))
    assert robot.channel.wait_until(lambda: run.status.step == (2,), TIMEOUT)
    robot.run(0.3)
    robot.scene.add("late", Box(size=(0.5, 0.02, 1.0)), xyz=(0.3, -0.2, 0.6))
    end = run.wait(TIMEOUT)
    assert end.state == "failed"
    assert "'late'" in end.error
    assert "which the plan does not expect" in end.error
    robot.run(0.5)
    assert not robot.arm.control_box.state.taken_by
    assert max(map(abs, robot.joint_state.velocity.values())) < 0.05


def test_a_way_in_real_time() -> None:
    with tool0.bringup(arm="ur5e", gripper=None, speed=10.0) as robot:
        end = robot.run_program(program(around(LEFT, speed=3.0))).wait(TIMEOUT)
        assert end.state == "succeeded", end.error
        assert robot.arm.pose().position == pytest.approx(LEFT.xyz, abs=2e-3)


def test_no_way_fails_with_the_reason(robot: tool0.Robot) -> None:
    inside = around(at(0.5, 0.0, 0.15))
    steps = program(LoopStep(times=1, steps=(inside, around(LEFT))))
    found = robot.programs.check(steps)
    assert found.problems == ()
    (warning,) = found.warnings
    assert warning.step == (1, 1)
    assert "no way as the scene is now: no posture of the target" in warning.text
    end = robot.run_program(steps).wait(TIMEOUT)
    assert end.state == "failed"
    assert end.error.startswith("step 1.1: no posture of the target is free")


def test_the_check_shows_the_way(robot: tool0.Robot) -> None:
    found = robot.programs.check(
        program(around(LEFT), around(RIGHT), MoveLinearStep(pose=at(0.4, -0.35, 0.25)))
    )
    assert found.problems == found.warnings == ()
    assert list(dict.fromkeys(found.motion.steps)) == [(1,), (2,), (3,)]
    direct = robot.programs.check(
        program(MoveJointStep(pose=LEFT), MoveJointStep(pose=RIGHT))
    )
    y = [point[1] for point in found.motion.points]
    assert min(y) == pytest.approx(-0.35, abs=0.05)
    assert found.motion.times[-1] > direct.motion.times[-1]


@pytest.mark.parametrize(
    ("steps", "step", "text"),
    [
        ((around(at(2.0, 0.0, 0.3)),), (1,), "out of reach"),
        ((around(LEFT, blend=0.05),), (1,), "'blend' must be 0"),
        (
            (MoveJointStep(pose=LEFT, blend=0.05), CommentStep(text="."), around(LEFT)),
            (1,),
            "step 3 is planned from where this one rests: its 'blend' must be 0",
        ),
    ],
)
def test_what_cannot_be_planned_is_a_problem(
    robot: tool0.Robot,
    steps: tuple[tool0.protocol.program.Step, ...],
    step: tuple[int, ...],
    text: str,
) -> None:
    (problem,) = robot.programs.check(program(*steps)).problems
    assert problem.step == step
    assert text in problem.text


def test_a_program_refuses_a_move_that_would_collide(robot: tool0.Robot) -> None:
    steps = (
        around(LEFT),
        MoveJointStep(pose=LEFT, blend=0.01),
        MoveLinearStep(pose=RIGHT),
    )
    assert robot.programs.check(program(*steps)).problems == ()
    end = robot.run_program(program(*steps, collision="refuse")).wait(TIMEOUT)
    assert end.state == "failed"
    assert "step 2: the arm would collide on the way of step 3: " in end.error
    assert "'wall'" in end.error
    robot.run(0.2)
    assert robot.arm.pose().position == pytest.approx(LEFT.xyz, abs=2e-3)
    free = program(around(RIGHT), WaitStep(duration=0.01), collision="refuse")
    assert robot.run_program(free).wait(TIMEOUT).state == "succeeded"


def test_exports_of_a_planned_step(robot: tool0.Robot) -> None:
    steps = program(around(LEFT), collision="refuse")
    text = robot.programs.export(steps, "python")
    assert "plan=True" in text
    assert "COLLISION = 'refuse'" in text
    assert "plan: true" in robot.programs.export(steps, "yaml")
    with pytest.raises(tool0.ProgramError, match=r"step 1: URScript cannot plan"):
        robot.programs.export(steps, "urscript")
    checked = program(MoveJointStep(pose=LEFT), collision="refuse")
    script = robot.programs.export(checked, "urscript")
    assert "# the controller does not check moves for collisions" in script
