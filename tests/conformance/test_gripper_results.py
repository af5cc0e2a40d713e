"""What stopped a gripper: results, programs and the API tell the same truth."""

from __future__ import annotations

import pytest
from conformance_types import BringUp

import tool0
from tool0 import GripperStep, Program
from tool0.protocol.goals import GoalStatus, GripperResult
from tool0.scene import Box

CLOSED = GripperStep(opening="closed", must_hold=False)


@pytest.fixture
def robot(bring_up: BringUp) -> tool0.Robot:
    robot = bring_up(arm="ur5e", initial_pose="home", gripper_action=True)
    robot.run(0.2)
    return robot


def result_of_closing(robot: tool0.Robot) -> GripperResult:
    result = robot.gripper.move(opening=0.0, force=60.0).wait(10.0)
    assert isinstance(result, GripperResult)
    return result


def part_at_pads(robot: tool0.Robot, offset: float) -> None:
    """Fix a box between the pads, or in the way of one of them."""
    T = robot.arm.pose() @ robot.gripper.tcp()
    p, R = T.position, T.matrix[:3, :3]
    xyz = tuple(p[k] + offset * R[k, 1] for k in range(3))
    robot.scene.add("part", Box(size=(0.03, 0.03, 0.03)), xyz=xyz)


def test_nothing_between_the_pads(robot: tool0.Robot) -> None:
    result = result_of_closing(robot)
    assert (result.reached_goal, result.stalled, result.holds) == (True, False, False)
    assert not result.error_string
    assert (
        robot.run_program(Program(name="close", steps=(CLOSED,))).wait(10.0).error == ""
    )
    must = GripperStep(opening="closed", must_hold=True)
    end = robot.run_program(Program(name="grip", steps=(must,))).wait(10.0)
    assert end.state == "failed"
    assert "holds nothing" in end.error


def test_a_part_between_the_pads(robot: tool0.Robot) -> None:
    part_at_pads(robot, 0.0)
    result = result_of_closing(robot)
    assert (result.reached_goal, result.stalled, result.holds) == (False, True, True)
    assert "stopped by what it holds" in result.error_string
    assert "touches 'part'" in result.error_string
    assert robot.gripper.wait(5.0).motion == "holding_inside"


def test_a_part_in_the_way_of_one_finger(robot: tool0.Robot) -> None:
    part_at_pads(robot, 0.025)
    goal = robot.gripper.move(opening=0.0, force=60.0)
    assert robot.gripper.wait(5.0).motion == "blocked"
    robot.run(3.0)
    assert goal.status is not GoalStatus.SUCCEEDED
    if goal.result is not None:  # the joint may also creep
        assert isinstance(goal.result, GripperResult)
        assert not goal.result.holds
        assert goal.result.error_string.startswith("blocked (")
    robot.gripper.move(opening=0.085).wait(10.0)
    weak = GripperStep(opening="closed", force=25.0)  # 60 N bend the arm aside
    end = robot.run_program(Program(name="close", steps=(weak,))).wait(30.0)
    assert end.state == "failed"
    assert "blocked and holds nothing" in end.error
    assert "touches 'part'" in end.error
