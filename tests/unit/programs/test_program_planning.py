from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

import tool0
from tool0 import (
    CommentStep,
    LoopStep,
    MoveJointStep,
    MoveLinearStep,
    PlaceObjectStep,
    Program,
    ProgramCheck,
    ToolPose,
    UntilStep,
    WaitStep,
)
from tool0.scene import Sphere

DOWN = (math.pi, 0.0, 0.0)


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(arm="ur5e", realtime=False) as robot:
        yield robot


def arm(y: float) -> tool0.DescriptionConfig:
    return tool0.DescriptionConfig(arm="ur3e", base_xyz=(0.0, y, 0.0))


def to(x: float, y: float, z: float, blend: float = 0.0) -> MoveLinearStep:
    return MoveLinearStep(pose=ToolPose(xyz=(x, y, z), rpy=DOWN), blend=blend)


FIRST = MoveJointStep(pose=ToolPose(xyz=(0.4, 0.1, 0.4), rpy=DOWN))
SECOND = to(0.4, 0.1, 0.3)
THIRD = to(0.4, -0.1, 0.3)


def check(robot: tool0.Robot, *steps: tool0.protocol.program.Step) -> ProgramCheck:
    return robot.programs.check(Program(name="p", steps=steps))


def test_the_preview_leads_through_the_targets(robot: tool0.Robot) -> None:
    found = check(
        robot, FIRST, CommentStep(text="x"), SECOND, WaitStep(duration=1), THIRD
    )
    assert found.problems == found.warnings == ()
    motion = found.motion
    points, times = np.array(motion.points), np.array(motion.times)
    assert len(points) == len(motion.positions) == len(motion.steps) == len(times)
    assert (np.diff(times) >= 0.0).all()
    assert motion.joint_names == robot.arm.joint_names
    assert list(dict.fromkeys(motion.steps)) == [(1,), (3,), (5,)]
    for target in ((0.4, 0.1, 0.4), (0.4, 0.1, 0.3), (0.4, -0.1, 0.3)):
        assert np.linalg.norm(points - target, axis=1).min() < 0.005
    np.testing.assert_allclose(points[-1], (0.4, -0.1, 0.3), atol=1e-6)
    start = [robot.arm.joints[name] for name in motion.joint_names]
    assert motion.positions[0] == pytest.approx(start, abs=5e-3)


def test_the_preview_of_a_long_program_is_bounded(robot: tool0.Robot) -> None:
    found = check(robot, FIRST, *(SECOND, THIRD) * 25)
    assert found.problems == ()
    assert 1000 < len(found.motion.times) < 2000


def test_a_loop_is_planned_from_where_it_ends(robot: tool0.Robot) -> None:
    turn = MoveLinearStep(pose=ToolPose(xyz=(0.4, -0.1, 0.3), rpy=(math.pi, 0.0, 3.0)))
    twice = LoopStep(times=2, steps=(SECOND, turn))
    assert check(robot, FIRST, SECOND, twice).problems == ()
    # From its end, the way back through the base is impossible.
    behind = to(-0.4, 0.1, 0.3)
    around = MoveJointStep(pose=ToolPose(xyz=(-0.4, 0.1, 0.3), rpy=DOWN))
    once = LoopStep(times=1, steps=(SECOND, around))
    assert check(robot, FIRST, once, behind).problems == ()
    again = LoopStep(times=2, steps=(SECOND, around))
    (problem,) = check(robot, FIRST, again, behind).problems
    assert problem.step == (2, 1)
    assert "cannot come nearer" in problem.text


def test_moves_after_a_search_are_planned_from_both_ends(robot: tool0.Robot) -> None:
    search = UntilStep(direction=(0.0, 0.0, -1.0), distance=0.15)
    assert check(robot, FIRST, search, THIRD).problems == ()
    up = UntilStep(direction=(0.0, 1.0, 0.0), distance=2.0)
    (problem,) = check(robot, FIRST, up).problems
    assert problem.step == (2,)
    assert "out of reach" in problem.text


def test_steps_after_an_endless_loop_are_reported(robot: tool0.Robot) -> None:
    found = check(robot, FIRST, LoopStep(steps=(SECOND, THIRD)), SECOND)
    assert found.problems == ()
    (warning,) = found.warnings
    assert warning.step == (3,)
    assert "never reached" in warning.text


def test_overlapping_blends_are_a_problem_of_the_step(robot: tool0.Robot) -> None:
    wide = to(0.4, 0.1, 0.3, blend=0.09)
    (problem,) = check(
        robot, FIRST, wide, to(0.4, 0.1, 0.25, blend=0.04), THIRD
    ).problems
    assert problem.step == (2,)
    assert "overlapping blends" in problem.text


def test_a_move_that_must_be_slower_is_a_warning(robot: tool0.Robot) -> None:
    fast = MoveLinearStep(pose=THIRD.pose, speed=5.0, acceleration=20.0)
    found = check(robot, FIRST, SECOND, fast)
    assert found.problems == ()
    assert [item.step for item in found.warnings] == [(3,)]


def test_every_problem_of_single_steps_is_reported_at_once(robot: tool0.Robot) -> None:
    wrong = MoveJointStep(named_pose="nowhere")
    loop = LoopStep(times=2, steps=(wrong, SECOND, WaitStep()))
    found = check(robot, FIRST, loop, wrong)
    assert [item.step for item in found.problems] == [(2, 1), (2, 3), (3,)]
    assert found.motion.times == ()


def test_too_many_steps_are_refused(robot: tool0.Robot) -> None:
    (problem,) = check(robot, *(CommentStep(text="x"),) * 2001).problems
    assert problem.text == "the program has 2001 steps; 2000 is the most"


def test_joints_may_leave_out_the_prefix_of_a_cell(robot: tool0.Robot) -> None:
    with tool0.bringup(
        cell=tool0.Cell(
            robots=(
                tool0.CellRobot(name="left", description=arm(0.5)),
                tool0.CellRobot(name="right", description=arm(-0.5)),
            )
        ),
        realtime=False,
    ) as cell:
        names = robot.arm.joint_names
        joints = dict(zip(names, (0.1, -1.5, 1.5, -1.5, -1.5, 0.1), strict=True))
        wait = Program(name="w", arm="left", steps=(WaitStep(duration=0.5),))
        move = Program(name="m", arm="right", steps=(MoveJointStep(joints=joints),))
        handles = [cell.run_program(wait), cell.run_program(move)]
        assert [handle.status.arm for handle in handles] == ["left", "right"]
        assert [handle.wait(20.0).state for handle in handles] == ["succeeded"] * 2
        reached = cell.joint_state.position
        for name, position in joints.items():
            assert reached[f"right_{name}"] == pytest.approx(position, abs=0.01)


@pytest.mark.parametrize(
    ("step", "said"),
    [
        (
            MoveLinearStep(pose=ToolPose(xyz=(0.4, 0.1, 0.3), rpy=(180.0, 0.0, 0.0))),
            "rpy: 180 rad is no plausible angle; did you mean 180deg = 3.142 rad?",
        ),
        (
            MoveLinearStep(pose=ToolPose(xyz=(0.4, 0.1, 0.3), rpy=DOWN), speed=50.0),
            "speed: 50 m/s is no plausible speed; did you mean 50mm/s = 0.05 m/s?",
        ),
        (
            UntilStep(direction=(0.0, 0.0, -1.0), distance=0.1, speed=20.0),
            "did you mean 20mm/s = 0.02 m/s?",
        ),
        (
            MoveJointStep(pose=ToolPose(xyz=(400.0, 100.0, 300.0), rpy=DOWN)),
            "; did you mean 509.865mm",
        ),
        (
            PlaceObjectStep(name="part", xyz=(0.4, 0.1, 0.3), rpy=(0.0, 0.0, 90.0)),
            "did you mean 90deg = 1.571 rad?",
        ),
    ],
)
def test_values_in_another_unit_are_named(
    robot: tool0.Robot, step: tool0.protocol.program.Step, said: str
) -> None:
    if isinstance(step, PlaceObjectStep):
        robot.scene.add(step.name, Sphere(radius=0.01), xyz=(1.0, 0.0, 0.5))
    (problem,) = check(robot, step).problems
    assert problem.step == (1,)
    assert said in problem.text


@pytest.mark.parametrize(
    ("tool", "said"),
    [
        (ToolPose(xyz=(0.0, 0.0, 0.1), rpy=(0.0, 45.0, 0.0)), "rpy: 45 rad"),
        (ToolPose(xyz=(0.0, 0.0, 0.1), relative_to="nowhere"), "nowhere"),
    ],
)
def test_a_wrong_tool_is_a_problem(
    robot: tool0.Robot, tool: ToolPose, said: str
) -> None:
    found = robot.programs.check(Program(name="p", tool=tool, steps=(FIRST,)))
    (problem,) = found.problems
    assert said in problem.text
