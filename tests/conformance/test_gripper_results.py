"""What stopped a gripper: results, programs and the API tell the same, and the truth."""

from __future__ import annotations

import math

import pytest
from conformance_types import BringUp

import tool0
from tool0 import GripperStep, MoveLinearStep, Program, ToolPose
from tool0.control.goal import GripperResult
from tool0.scene import Box

DOWN = (math.pi, 0.0, 0.0)
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


def part_at_pads(robot: tool0.Robot, offset: float, *, mass: float | None) -> None:
    """Put a box between the pads, or in the way of one of them."""
    T = robot.arm.pose() @ robot.gripper.tcp()
    p, R = T.position, T.matrix[:3, :3]
    xyz = tuple(p[k] + offset * R[k, 1] for k in range(3))
    robot.scene.add("part", Box(size=(0.03, 0.03, 0.03)), xyz=xyz, mass=mass)


def test_nothing_between_the_pads(robot: tool0.Robot) -> None:
    result = result_of_closing(robot)
    assert (result.reached_goal, result.stalled, result.holds) == (True, False, False)
    assert not result.error_string
    assert robot.run_program(Program(name="close", steps=(CLOSED,))).wait(10.0).error == ""
    must = GripperStep(opening="closed", must_hold=True)
    end = robot.run_program(Program(name="grip", steps=(must,))).wait(10.0)
    assert end.state == "failed"
    assert "holds nothing" in end.error


def test_a_part_between_the_pads(robot: tool0.Robot) -> None:
    part_at_pads(robot, 0.0, mass=0.2)
    result = result_of_closing(robot)
    assert (result.reached_goal, result.stalled, result.holds) == (False, True, True)
    assert "stopped by what it holds" in result.error_string
    assert "touches 'part'" in result.error_string
    assert robot.gripper.wait(5.0).motion == "holding_inside"


def test_a_part_that_is_fixed_in_the_way_of_one_finger(robot: tool0.Robot) -> None:
    part_at_pads(robot, 0.02, mass=None)
    result = result_of_closing(robot)
    assert (result.reached_goal, result.stalled, result.holds) == (False, True, False)
    assert result.error_string.startswith("blocked (")
    assert "touches 'part'" in result.error_string
    assert robot.gripper.wait(5.0).motion == "blocked"
    robot.gripper.move(opening=0.06).wait(10.0)
    end = robot.run_program(Program(name="close", steps=(CLOSED,))).wait(20.0)
    assert end.state == "failed"
    assert "blocked and holds nothing" in end.error
    assert "touches 'part'" in end.error
